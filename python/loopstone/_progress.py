"""How far a long call is, on the terminal or to whoever asks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple


class Progress(NamedTuple):
    """How far a piece of work has come."""

    step: str
    """What is being done: ``mapping``."""
    done: int
    """In the unit of ``total``: bytes of a log, steps of a search."""
    total: int
    """0 when it is unknown."""
    scans: int
    """Finished so far, where that makes sense."""
    recorded_s: float
    """Time of the recording that was dealt with."""

    @property
    def fraction(self) -> float | None:
        """From 0 to 1; None when it is unknown."""
        return min(1.0, self.done / self.total) if self.total > 0 else None


#: What long calls take: False for nothing, True for a bar by tqdm, or who is to be told.
ProgressLike = bool | Callable[[Progress], object]

_Told = Callable[[str, int, int, int, float], None]


class _Bar:
    """A bar of tqdm for each step."""

    def __init__(self, tqdm: Any) -> None:
        self._tqdm = tqdm
        self._bar: Any = None
        self._step = ""

    def __call__(self, step: str, done: int, total: int, scans: int, recorded_s: float) -> None:
        if step != self._step or self._bar is None:
            self.close()
            self._step = step
            self._bar = self._tqdm(desc=step, total=total or None, leave=False, unit_scale=True)
        self._bar.set_postfix_str(f"{scans} scans" if scans else "", refresh=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


@contextmanager
def told(progress: ProgressLike) -> Iterator[_Told | None]:
    """What the extension calls while it works.

    True asks for tqdm, and for nothing where it is not installed.
    """
    if progress is False:
        yield None
    elif progress is True:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            yield None
            return
        bar = _Bar(tqdm)
        try:
            yield bar
        finally:
            bar.close()
    else:

        def tell(step: str, done: int, total: int, scans: int, recorded_s: float) -> None:
            progress(Progress(step, done, total, scans, recorded_s))

        yield tell
