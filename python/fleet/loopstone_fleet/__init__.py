"""Maps and judges many logs with Loopstone: `loopstone-fleet run MANIFEST -o OUT`."""

from __future__ import annotations

from importlib.metadata import version

__version__ = version("loopstone-fleet")
