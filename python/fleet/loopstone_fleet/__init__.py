"""Maps and judges many logs with Loopstone: `loopstone-fleet run MANIFEST -o OUT`."""

from __future__ import annotations

__version__ = "0.1.0"
