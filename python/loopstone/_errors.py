"""What is raised when a file or an option can't be used. Texts are those of the program."""

from __future__ import annotations

import os
from typing import NamedTuple


class Error(Exception):
    """Anything that Loopstone itself has to say against what it was given."""


class UsageError(Error, ValueError):
    """Bad usage or options: what was asked for makes no sense. The program exits with 2."""


class OptionProblem(NamedTuple):
    """An option that could not be taken, with everything that is needed to put it right."""

    key: str
    """Dotted name; empty when a file as a whole can't be read."""
    value: str
    """As it was given; empty when the key is the problem."""
    rule: str
    """What would be right."""
    source: str
    """The file, or ``options`` for what a program gave."""
    line: int | None
    """Of the file, from 1; None for what a program gave."""


class OptionsError(UsageError):
    """Several things wrong with the options, all at once: the text has one line for each."""

    def __init__(self, text: str, problems: tuple[OptionProblem, ...] = ()) -> None:
        super().__init__(text, problems)
        self.problems = problems
        """All of them, in the order of the text."""

    def __str__(self) -> str:
        return str(self.args[0])


class DataError(Error, ValueError):
    """Bad data: what a file holds can't be used. The program exits with 1."""

    def __init__(
        self, text: str, path: str = "", line: int | None = None, byte_offset: int | None = None
    ) -> None:
        super().__init__(text, path, line, byte_offset)
        self.path = path
        """The file at fault."""
        self.line = line
        """Its line, from 1, when it is text."""
        self.byte_offset = byte_offset
        """The place in it, when it is binary."""

    def __str__(self) -> str:
        return str(self.args[0])


class MissingFileError(DataError, FileNotFoundError):
    """The same for a file or folder that is not there."""

    def __str__(self) -> str:
        return str(self.args[0])


def data_error(text: str, path: str, line: int | None, byte_offset: int | None) -> DataError:
    """The error that fits: whether the file is there decides."""
    is_place = line is not None or byte_offset is not None
    missing = bool(path) and path != "-" and not is_place and not os.path.lexists(path)
    return (MissingFileError if missing else DataError)(text, path, line, byte_offset)
