"""What the user must be told before or instead of work: the command then ends with 2."""

from __future__ import annotations


class FleetError(Exception):
    """A call or a manifest that can't be used, in a sentence that says what to do."""


class StoreError(Exception):
    """A store of logs did not give what it has. It may the next time."""


class MissingLogError(Exception):
    """There is no log where the manifest says."""


class LogTooLargeError(Exception):
    """A log is larger than what may be fetched."""
