"""Edits of a map from keyword arguments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._core import EditReport, MapEditor


def _toml(value: Any) -> str:
    """A value as TOML has it."""
    import json

    item = getattr(value, "tolist", None)  # of NumPy
    if item is not None:
        value = item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, Mapping):
        raise TypeError("a key of an edit has no table")
    return "[" + ", ".join(_toml(one) for one in value) + "]"


def add(editor: MapEditor, kind: str, /, **keys: Any) -> EditReport:
    lines = [f"{key} = {_toml(value)}" for key, value in {"kind": kind, **keys}.items()]
    from . import _core

    return _core.add_edit(editor, "[[edit]]\n" + "\n".join(lines) + "\n")
