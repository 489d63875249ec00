"""What the classes of loopstone.options have in common."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any, ClassVar


class OptionGroup:
    """Some options; fields that are groups themselves have more."""

    __slots__ = ()

    def _leaves(self, prefix: str = "") -> Iterator[tuple[str, Any]]:
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, OptionGroup):
                yield from value._leaves(f"{prefix}{field.name}.")
            else:
                yield prefix + field.name, value

    def to_dict(self) -> dict[str, Any]:
        """Every option by its dotted key: ``{"map.resolution_m": 0.05, ...}``."""
        return dict(self._leaves())

    def changed(self) -> dict[str, Any]:
        """Those that are other than by default, by their dotted keys."""
        defaults = type(self)().to_dict()
        return {key: value for key, value in self._leaves() if not value == defaults[key]}


class CallOptions(OptionGroup):
    """All options of one call."""

    __slots__ = ()
    _of: ClassVar[str]

    def to_toml(self) -> str:
        """The effective options as ``loopstone config`` prints them.

        Raises OptionsError with everything that is wrong with them.
        """
        from . import _core, _values

        return _core.options_toml(self._of, _values.option_values(type(self).__name__, self, {}))

    def check(self) -> None:
        """Raises OptionsError with everything that is wrong with them."""
        self.to_toml()
