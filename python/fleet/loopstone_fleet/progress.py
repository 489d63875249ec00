"""How far a run is, on stderr: a line that renews on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from typing import TextIO

TERMINAL_EVERY_S = 0.2
PLAIN_EVERY_S = 30.0


class Progress:
    """Counts logs and tells of them."""

    def __init__(self, total: int, stream: TextIO | None = None, quiet: bool = False) -> None:
        self._total = total
        self._stream = stream or sys.stderr
        self._quiet = quiet
        self._is_terminal = self._stream.isatty()
        self._started = self._told = time.monotonic()
        self.skipped = 0
        self.done = 0
        self.failed = 0

    def say(self, text: str) -> None:
        """A sentence that stays."""
        if not self._quiet:
            clear = "\r\x1b[K" if self._is_terminal else ""
            print(f"{clear}{text}", file=self._stream, flush=True)

    def tell(self, running: int, waiting_for: str = "", at_once: bool = False) -> None:
        """Renews the line when it is time to."""
        now = time.monotonic()
        every = TERMINAL_EVERY_S if self._is_terminal else PLAIN_EVERY_S
        if self._quiet or (now - self._told < every and not at_once):
            return
        self._told = now
        text = self.line(running, now - self._started)
        text += f"; {waiting_for}" if waiting_for else ""
        if self._is_terminal:
            self._stream.write(f"\r\x1b[K{text}")
        else:
            self._stream.write(f"{text}\n")
        self._stream.flush()

    def line(self, running: int, elapsed_s: float) -> str:
        """Such as: 120 of 1000 logs: 100 done, 5 failed, 15 as before; 2 running; 12 min left."""
        ended = self.done + self.failed
        left = self._total - self.skipped - ended
        parts = [f"{self.done} done", f"{self.failed} failed"]
        parts += [f"{self.skipped} as before"] if self.skipped else []
        text = f"{ended + self.skipped} of {self._total} logs: {', '.join(parts)}"
        text += f"; {running} running" if running else ""
        if left and ended:
            text += f"; {duration_text(elapsed_s / ended * left)} left"
        return text

    def end(self) -> None:
        if self._is_terminal and not self._quiet:
            self._stream.write("\r\x1b[K")
        self.say(self.line(0, 0.0))


def duration_text(seconds: float) -> str:
    """Two digits of a time, with its unit."""
    for unit, size in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            value = seconds / size
            return f"{value:.1f} {unit}" if value < 10 and unit != "min" else f"{value:.0f} {unit}"
    return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1f} s"
