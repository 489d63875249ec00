#!/usr/bin/env python3
"""Holds the documentation to the truth: what pages say about the program must be so.

  tests/docs/check_docs.py PROGRAM       generated sections, commands and flags, keys of
                                         summary.json, formats of logs, links
  tests/docs/check_docs.py --self-test   each check finds what it should
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]

CODE = re.compile(r"```.*?```|`[^`\n]+`|(?:^    .*\n)+", re.S | re.M)
# `import loopstone as ls` is no call.
CALL = re.compile(r"(?<!import )(?<![\w/.:-])(?:[\w./$-]*/)?loopstone +([a-z]+)\b([^\n|;&`]*)")
FLAG = re.compile(r"(?<![\w-])(--[a-z][a-z-]*)")
LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)#\s]+)")


def output_of(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout.decode()


def help_texts(program):
    general = output_of(program, "--help")
    listed = re.search(r"^Subcommands:\n((?:  .*\n)+)", general, re.M).group(1)
    return {name: whole_help(program, name) for name in re.findall(r"^  (\w+)", listed, re.M)}


def whole_help(program, name):
    """Of a command, and of those that it has itself."""
    text = output_of(program, name, "--help")
    inner = re.search(r"^Subcommands:\n((?:  .*\n)+)", text, re.M)
    names = re.findall(r"^  (\w+)", inner.group(1), re.M) if inner else []
    return text + "".join(output_of(program, name, one, "--help") for one in names)


def wrong_calls(text, helps):
    """`loopstone COMMAND --flag` in code, where the program has no such command or flag."""
    for code in CODE.findall(text):
        for command, rest in CALL.findall(code.replace("\\\n", " ")):
            if command not in helps:
                yield f"there is no command `loopstone {command}`"
                continue
            known = set(FLAG.findall(helps[command])) | {"--help"}
            for flag in FLAG.findall(rest):
                if flag not in known:
                    yield f"`loopstone {command}` has no flag {flag}"


def broken_links(text, folder):
    for target in LINK.findall(CODE.sub("", text)):  # a lambda, [](double x), is no link
        if not (folder / target).exists():
            yield f"link to {target}, which does not exist"


def unlisted(pages, overview):
    """Pages that docs/README.md does not lead to."""
    yield from (f"leads not to {page}" for page in pages if f"({page})" not in overview)


def undocumented(keys, documented):
    yield from (
        f"summary.json has {key}, which the table lacks" for key in keys if key not in documented
    )
    yield from (
        f"the table names {key}, which summary.json has not"
        for key in documented
        if key not in keys
    )


def documented_keys(page):
    section = page.split("### summary.json", 1)[1].split("\n#", 1)[0]
    return [
        key
        for row in re.findall(r"^\| (`.*?) \|", section, re.M)
        for key in re.findall(r"`(\w+)`", row)
    ]


def summary_keys(program):
    """Keys of the summaries of real, short runs, by the page that has their table."""
    with tempfile.TemporaryDirectory() as folder:
        log, out, where = f"{folder}/log", f"{folder}/out", f"{folder}/where"
        output_of(
            program, "simulate", "rooms", "-o", log, "--duration", "6", "--beams", "91", "--quiet"
        )
        output_of(program, "map", log, "-o", out, "--quiet")
        output_of(
            program,
            "localize",
            log,
            "--map",
            out,
            "-o",
            f"{where}.tum",
            "--initial",
            "0,0,0",
            "--report",
            where,
            "--quiet",
        )
        return {
            page: re.findall(
                r'^  "(\w+)":', pathlib.Path(run, "summary.json").read_text(encoding="utf-8"), re.M
            )
            for page, run in [("docs/formats.md", out), ("docs/localization.md", where)]
        }


def formats_not_named(formats, page):
    """Formats of logs that a page should tell of in words of its own."""
    yield from (
        f"does not name the log format {entry['noun']}"
        for entry in formats
        if entry["noun"] not in page
    )


def check(program):
    problems = []
    done = subprocess.run(
        [sys.executable, ROOT / "scripts/write_docs.py", "--check", "--program", program],
        stderr=subprocess.PIPE,
    )
    if done.returncode != 0:
        problems.append(done.stderr.decode().strip())
    helps = help_texts(program)
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        name = page.relative_to(ROOT)
        problems += [f"{name}: {problem}" for problem in wrong_calls(text, helps)]
        problems += [f"{name}: {problem}" for problem in broken_links(text, page.parent)]
    formats = json.loads(output_of(program, "info", "--formats", "--json"))["formats"]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    problems += [f"README.md: {problem}" for problem in formats_not_named(formats, readme)]
    others = [
        page.name for page in PAGES if page.parent.name == "docs" and page.name != "README.md"
    ]
    overview = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    problems += [f"docs/README.md: {problem}" for problem in unlisted(others, overview)]
    for page, keys in summary_keys(program).items():
        documented = documented_keys((ROOT / page).read_text(encoding="utf-8"))
        problems += [f"{page}: {problem}" for problem in undocumented(keys, documented)]
    return problems


def self_test():
    helps = {"map": "  -o,--output OUT\n  --threads N\n", "info": "  --json\n"}
    good = (
        "Run `loopstone map LOG -o OUT --threads 2`, then\n\n    build/release/bin/loopstone info"
        " LOG --json\n"
    )
    assert not list(wrong_calls(good, helps)), list(wrong_calls(good, helps))
    assert list(wrong_calls("```\nloopstone mapp LOG\n```", helps)) == [
        "there is no command `loopstone mapp`"
    ]
    assert list(wrong_calls("    loopstone map LOG \\\n      --treads 2\n", helps)) == [
        "`loopstone map` has no flag --treads"
    ]
    assert not list(
        wrong_calls(
            "loopstone is not a command here; `find_package(loopstone REQUIRED)` neither", helps
        )
    )
    assert list(broken_links("[a](no/such.md) [b](https://x.org/y)", ROOT)) == [
        "link to no/such.md, which does not exist"
    ]
    assert not list(broken_links("```cpp\nauto f = [](double x) { return x; };\n```", ROOT))
    assert list(formats_not_named([{"noun": "an A bag"}, {"noun": "B text"}], "reads B text")) == [
        "does not name the log format an A bag"
    ]
    assert documented_keys(
        "### summary.json\n| key | what |\n|---|---|\n| `a`, `b_m` | x `no` |\n"
    ) == ["a", "b_m"]
    assert list(unlisted(["a.md", "b.md"], "see [a](a.md)")) == ["leads not to b.md"]
    assert list(undocumented(["a"], ["b"])) == [
        "summary.json has a, which the table lacks",
        "the table names b, which summary.json has not",
    ]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--self-test":
        self_test()
        return
    problems = check(sys.argv[1])
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
