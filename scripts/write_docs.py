#!/usr/bin/env python3
"""Writes the parts of the docs that the program itself knows: the help of every command and all
options (docs/command_line.md), the formats of sensor logs (docs/formats.md), and the options of
localisation (docs/localization.md) and of the texture (docs/texture.md).

  scripts/write_docs.py [--program build/release/bin/loopstone]            writes
  scripts/write_docs.py [--program build/release/bin/loopstone] --check
                                            tells whether the page is up to date (exit 1: no)
"""
import argparse
import json
import pathlib
import re
import sys

from doc_blocks import read_block, table, write_block
from program_help import output_of, parse_help

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/command_line.md"
LOCALIZATION_PAGE = ROOT / "docs/localization.md"
TEXTURE_PAGE = ROOT / "docs/texture.md"
FORMATS_PAGE = ROOT / "docs/formats.md"


def help_block(title, text):
    lines = [line.rstrip() for line in text.strip("\n").splitlines()]
    return f"## {title}\n\n```text\n" + "\n".join(lines) + "\n```\n"


def command_help(program):
    general = output_of(program, "--help")
    parts = [help_block("loopstone", general)]
    for command in parse_help("", general).commands:
        parts += command_blocks(program, command)
    return "\n".join(parts)


def command_blocks(program, *words):
    """Of a command, and of those that it has itself."""
    text = output_of(program, *words, "--help")
    parts = [help_block("loopstone " + " ".join(words), text)]
    for inner in parse_help(" ".join(words), text).commands:
        parts += command_blocks(program, *words, inner)
    return parts


def options_table(program, command, only=""):
    """From the TOML of `loopstone config COMMAND`: each option follows its help text, whose last
    brackets hold the rule. Options whose names begin with `only`."""
    rows = []
    group = ""
    comment = ""
    for line in output_of(program, "config", command).splitlines():
        if line.startswith("["):
            group = line.strip("[]") + "."
        elif line.startswith("#"):
            comment = (comment + " " + line.lstrip("# ")).strip()
        elif "=" in line:
            key, value = (part.strip() for part in line.split("=", 1))
            meaning, rule = re.fullmatch(r"(.*?)(?: \(([^()]*)\))?", comment).groups()
            rows.append([f"`{group}{key}`", f"`{value}`", rule or "", meaning])
            comment = ""
    rows = [row for row in rows if row[0].startswith(f"`{only}")]
    if not rows:
        raise SystemExit("`loopstone config` printed no options")
    return table(["option", "default", "allowed", "meaning"], rows)


def formats_table(program):
    """Columns are formats, rows what each of them is and holds."""
    formats = json.loads(output_of(program, "info", "--formats", "--json"))["formats"]
    yes_no = {True: "yes", False: "no"}

    def files_of(entry):
        return ", ".join(f"`{ending}`" for ending in entry["endings"] + entry["packings"])

    def told(value):
        return yes_no[value] if isinstance(value, bool) else str(value)

    rows = [
        ["`--format`", *(f"`{entry['name']}`" for entry in formats)],
        ["a log is", *("a folder" if entry["is_folder"] else "a file" for entry in formats)],
        ["its files", *(files_of(entry) for entry in formats)],
        ["several sets in a folder", *(yes_no[entry["has_sets"]] for entry in formats)],
        ["from a pipe", *(yes_no[entry["from_pipes"]] for entry in formats)],
        ["written", *(yes_no[entry["written"]] for entry in formats)],
    ]
    for key in formats[0]["holds"]:
        name, unit = (key[:-3], " ns") if key.endswith("_ns") else (key, "")
        cells = [told(entry["holds"][key]) + unit for entry in formats]
        rows.append([name.replace("_", " "), *cells])
    return table(["", *(entry["noun"] for entry in formats)], rows)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()

    program = arguments.program
    stale = []
    for page, block, text in [
        (PAGE, "commands", command_help(program)),
        (PAGE, "options", options_table(program, "map")),
        (LOCALIZATION_PAGE, "options", options_table(program, "localize")),
        (LOCALIZATION_PAGE, "landmark options", options_table(program, "landmarks")),
        (FORMATS_PAGE, "log formats", formats_table(program)),
        (TEXTURE_PAGE, "options", options_table(program, "map", "texture.")),
    ]:
        if not arguments.check:
            write_block(page, block, text)
            continue
        written = read_block(page, block)
        if written is None or written.rstrip() != text.rstrip():
            stale.append(f"{page.relative_to(ROOT)} ({block})")
    if stale:
        sys.exit(f"out of date: {', '.join(stale)}. Run scripts/write_docs.py --program {program}")


if __name__ == "__main__":
    main()
