#!/usr/bin/env python3
"""Writes python/loopstone/options.py from what the C++ library says of its options.

    PYTHONPATH=build/release/python scripts/write_python_options.py          writes it
    PYTHONPATH=build/release/python scripts/write_python_options.py --check  fails where it differs

The descriptions are those of visit_options(), which flags, files and `loopstone config` have, too.
"""

import argparse
import importlib.machinery
import importlib.util
import sys
import textwrap
from pathlib import Path

FILE = Path(__file__).resolve().parent.parent / "python" / "loopstone" / "options.py"

# The class of a call's options, its name for describe_options(), what it is of; and the class
# before it that it has the options of, where it has more.
CALLS = [
    ("MapOptions", "map", "``loopstone.map`` and ``loopstone.Mapper``: ``loopstone config``."),
    ("LandmarkMapOptions", "landmark_map", "``loopstone.map`` with landmarks.", "MapOptions"),
    ("LocalizationOptions", "localize", "``loopstone.localize`` and ``loopstone.Localizer``."),
    ("LandmarkTrackingOptions", "landmarks", "``loopstone.localize`` among landmarks."),
    ("MatchOptions", "match", "``loopstone.match`` in the plane."),
    ("Match3dOptions", "match_3d", "``loopstone.match`` in space."),
    ("OptimizeOptions", "optimize", "``loopstone.optimize``."),
    ("SimulationOptions", "simulate", "``loopstone.simulate``."),
]

HEAD = '''"""The options of every call, with their defaults, rules and meaning.

Written by scripts/write_python_options.py from the descriptions that the program's flags and files
have: `loopstone config` shows the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from dataclasses import field as _field
from typing import ClassVar, Literal

from ._option_group import CallOptions, OptionGroup
'''


def tree_of(entries):
    """Nested dictionaries of what is described by dotted keys."""
    tree = {}
    for entry in entries:
        *groups, name = entry["key"].split(".")
        place = tree
        for group in groups:
            place = place.setdefault(group, {})
        place[name] = entry
    return tree


def is_group(node):
    return "key" not in node or isinstance(node["key"], dict)


def type_of(entry):
    if entry["words"]:
        return "Literal[" + ", ".join(f'"{word}"' for word in entry["words"]) + "]"
    return type(entry["default"]).__name__


def default_of(entry):
    value = entry["default"]
    return f'"{value}"' if isinstance(value, str) else repr(value)


def doc_of(entry):
    text = entry["help"]
    if not entry["words"] and entry["rule"] not in ("true or false", "text"):
        text += f" ({entry['rule']})"
    text = text.replace("\\", "\\\\")
    if len(text) <= 88:
        return f'    """{text}"""'
    lines = textwrap.wrap(text, 90)
    return '    """' + "\n    ".join(lines) + '\n    """'


def field_line(name, kind, value):
    """One field, broken as black does it."""
    line = f"    {name}: {kind} = {value}"
    if len(line) <= 100:
        return line
    if not value.endswith(")"):  # a word among others
        words = kind.removeprefix("Literal[").removesuffix("]")
        return f"    {name}: Literal[\n        {words}\n    ] = {value}"
    opened, closed = value[:-1].split("(", 1)
    return f"    {name}: {kind} = {opened}(\n        {closed}\n    )"


def class_of(name, base, tree, doc, call=None):
    """The class of a group, after those of the groups within."""
    stem = name.removesuffix("Options")
    before, fields = [], []
    for key, node in tree.items():
        if is_group(node):
            inner = stem + "".join(part.capitalize() for part in key.split("_")) + "Options"
            before.append(class_of(inner, "OptionGroup", node, f"The group ``{key}``."))
            fields.append(field_line(key, inner, f"_field(default_factory={inner})"))
        else:
            line = field_line(key, type_of(node), default_of(node))
            fields.append(f"{line}\n{doc_of(node)}")
    lines = [
        "@dataclass(kw_only=True, slots=True)",
        f"class {name}({base}):",
        f'    """{doc}"""',
        "",
    ]
    if call:
        lines += [f'    _of: ClassVar[str] = "{call}"', ""]
    return "\n\n\n".join([*before, "\n".join(lines + fields)])


def extension():
    """loopstone._core alone: the package may not import while its options are not current."""
    (folder,) = importlib.util.find_spec("loopstone").submodule_search_locations
    spec = importlib.machinery.PathFinder.find_spec("_core", [folder])
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def text_of_all():
    core = extension()
    calls = {name: call for name, call, *_ in CALLS}
    classes = []
    for name, call, doc, *more_than in CALLS:
        base = more_than[0] if more_than else "CallOptions"
        known = core.describe_options(calls[base]) if more_than else []
        entries = [entry for entry in core.describe_options(call) if entry not in known]
        classes.append(class_of(name, base, tree_of(entries), f"Of {doc}", call))
    return HEAD + "\n\n" + "\n\n\n".join(classes) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing, fail when it differs")
    arguments = parser.parse_args()
    text = text_of_all()
    if arguments.check:
        if FILE.read_text() != text:
            sys.exit(f"{FILE} is not what the library says: run scripts/write_python_options.py")
        return
    FILE.write_text(text)


if __name__ == "__main__":
    main()
