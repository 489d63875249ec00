#!/usr/bin/env python3
"""Holds every type to a name of its own: two types of one name in one namespace, each known to
other files, are undefined behaviour that no linker tells (their templates are taken for one).

    check_names.py ROOT        include/, src/, apps/, tests/support/, bench/ and fuzz/ at ROOT;
                               prints one line per breach; exits 1 if there is any
    check_names.py --self-test

It reads code as clang-format lays it out: what stands at the beginning of a line is of a namespace.
Types in a namespace without a name are their file's own.
"""
import collections
import pathlib
import re
import sys

FOLDERS = ("include", "src", "apps", "tests/support", "bench", "fuzz")
OPENS = re.compile(r"(?:inline )?namespace ?([\w:]*) ?\{$")
CLOSES = re.compile(r"\}  // namespace\b")
TYPE = re.compile(
    r"(?:struct|class|union|enum|enum class) (\w+)(?: final)?(?: :(?: .*)?)?(?: \{.*)?$"
)


def types_of(text):
    """Whole names of the types that a source defines and that other files can mean."""
    spaces = []
    lines = text.split("\n")
    for number, line in enumerate(lines):
        if opened := OPENS.match(line):
            spaces.append(opened.group(1))
        elif CLOSES.match(line) and spaces:
            spaces.pop()
        elif "" not in spaces and (match := TYPE.match(line)):
            # The brace may stand lines below, after the base classes.
            rest = " ".join(lines[number : number + 4])
            if re.match(r"[^;{]*\{", rest):
                yield "::".join([*spaces, match.group(1)])


def breaches_of(sources):
    """Of {path: text}: a line for each name that stands in several."""
    places = collections.defaultdict(set)
    for path, text in sources.items():
        for name in types_of(text):
            places[name].add(path)
    return [
        f"{name}: defined in {' and in '.join(sorted(paths))}"
        for name, paths in sorted(places.items())
        if len(paths) > 1
    ]


def check(root):
    paths = [path for folder in FOLDERS for path in sorted((root / folder).rglob("*.[ch]pp"))]
    if not paths:
        sys.exit(f"{root}: no sources")
    sources = {str(path.relative_to(root)): path.read_text(encoding="utf-8") for path in paths}
    breaches = breaches_of(sources)
    for breach in breaches:
        print(breach)
    if not breaches:
        count = sum(1 for text in sources.values() for _ in types_of(text))
        print(f"names: {count} types, each the only one of its name")
    return 1 if breaches else 0


def self_test():
    one = "namespace a {\n\nstruct X {\n  int b;\n};\n\n}  // namespace a\n"
    hidden = "namespace a {\nnamespace {\n\nstruct X {\n};\n\n}  // namespace\n}  // namespace a\n"
    other = one.replace("namespace a", "namespace c")
    declared = "namespace a {\nstruct X;\n}  // namespace a\n"
    derived = "namespace a {\nclass X final : public Y {\n};\n}  // namespace a\n"
    after = hidden.replace("}  // namespace a\n", "class X {\n};\n}  // namespace a\n")
    cases = [
        ("two of one name", one, one, 1),
        ("a derived class", one, derived, 1),
        ("another namespace", one, other, 0),
        ("a namespace without a name", one, hidden, 0),
        ("behind one without a name", one, after, 1),
        ("only declared", one, declared, 0),
        ("a part of it", one, one.replace("X {", "X::Part {"), 0),
    ]
    failed = 0
    for what, first, second, expected in cases:
        found = len(breaches_of({"first.hpp": first, "second.hpp": second}))
        if found != expected:
            print(f"self-test: {what}: {found} breaches, {expected} expected")
            failed += 1
    print(f"{len(cases) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(self_test() if sys.argv[1] == "--self-test" else check(pathlib.Path(sys.argv[1])))
