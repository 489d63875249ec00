"""``python -m loopstone_fleet`` is ``loopstone-fleet``."""

from __future__ import annotations

import sys

from loopstone_fleet.main import main

sys.exit(main())
