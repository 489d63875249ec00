"""The options of a row, however they are written, as the program takes them with --set."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Mapping
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Options = tuple[tuple[str, str], ...]
"""Dotted keys and values, by key: equal options are equal whatever order they were written in."""

_PAIR = re.compile(r"([A-Za-z_][\w.]*)=(\S*)")


def parse_options(given: Any) -> Options:
    """Options from a cell: nothing, an object, a list of KEY=VALUE, JSON of either, or TOML.

    ValueError, with what to write instead, for anything else.
    """
    if given is None:
        return ()
    if isinstance(given, Mapping):
        return _sorted(_flat(given, ""))
    if isinstance(given, (list, tuple)):
        return _sorted(_pair(word) for word in given)
    text = str(given).strip()
    if not text:
        return ()
    words = [word for word in text.split() if word != "--set"]
    if all(_PAIR.fullmatch(word) for word in words):
        return _sorted(_pair(word) for word in words)
    if text.startswith(("{", "[")):
        try:
            return parse_options(json.loads(text))
        except json.JSONDecodeError as error:
            if text.startswith("{"):
                raise ValueError(f"is no JSON: {error}") from None
    try:
        return _sorted(_flat(tomllib.loads(text), ""))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(
            f"is neither KEY=VALUE words nor JSON nor TOML ({error});"
            " write for example: map.resolution_m=0.02 front_end.odometry=ignore"
        ) from None


def _pair(word: Any) -> tuple[str, str]:
    match = _PAIR.fullmatch(str(word))
    if match is None:
        raise ValueError(f"has '{word}' where KEY=VALUE is wanted")
    return match[1], match[2]


def _flat(table: Mapping[str, Any], prefix: str) -> Iterable[tuple[str, str]]:
    for key, value in table.items():
        name = prefix + str(key)
        if isinstance(value, Mapping):
            yield from _flat(value, name + ".")
        elif isinstance(value, str):
            yield name, value
        elif isinstance(value, (bool, int, float)):
            yield name, json.dumps(value)
        else:
            raise ValueError(f"has '{name}' that is no number, word, true or false")


def _sorted(pairs: Iterable[tuple[str, str]]) -> Options:
    kept: dict[str, str] = {}
    for key, value in pairs:
        if kept.setdefault(key, value) != value:
            raise ValueError(f"has {key} twice, with different values")
    return tuple(sorted(kept.items()))
