#!/usr/bin/env python3
"""Holds every generated table to the release in work: what it says it was made of, and what `make
bench` makes again.

  tests/docs/check_tables.py             all pages; ends with 77 where tables could not be judged,
                                         and says how many and why
  tests/docs/check_tables.py --self-test

A table passes that was made of a commit of the version in work (include/loopstone/version.hpp), or
of an older one since which nothing changed that it depends on. It fails when it names a commit that
the history lacks; an older version fails it once CHANGELOG.md gives the version in work a day, and
is counted as not judged until then, like tables from before tables named their commit: `make bench`
makes them again.
"""
import collections
import os
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from provenance import git, provenance, stamps_of  # noqa: E402

SKIPPED = 77
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"<!-- begin: (.+?) -->\n(.*?)<!-- end: \1 -->", re.S)
VERSION_FILE = "include/loopstone/version.hpp"
VERSION = re.compile(r'kVersion = "([^"]+)"')
# Compared with the program by another test (docs.are_true, docs.bayes_filters), so no commit is
# needed to know that they hold.
COMPARED = {
    "commands",
    "options",
    "landmark options",
    "histogram filter",
    "particle filter",
    "output",
    "log formats",
}

PROGRAM = ["include", "src", "apps"]
PARTS = {
    "bench/pose_graphs.py": ["base", "geometry", "graph"],
    "bench/outliers.py": ["base", "geometry", "graph"],
    "bench/ray_cast.py": ["base", "geometry", "grid", "localization"],
    "bench/localization_speed.py": [
        "base",
        "geometry",
        "sensor",
        "grid",
        "registration",
        "localization",
    ],
    "bench/registration.py": ["base", "geometry", "sensor", "grid", "odometry", "registration"],
    "bench/file_readers.py": ["base", "sensor", "formats"],
    "bench/compare_ucsd_odometry.py": ["base", "geometry", "sensor", "odometry", "formats"],
}
# What is measured with the program.
BESIDE = {"bench/fleet.py": ["python/fleet/loopstone_fleet"]}


def sources_of(script):
    """What the figures of a script depend on; the number of the version is none of it."""
    parts = [
        f"{root}/{part}" for part in PARTS.get(script, []) for root in ("include/loopstone", "src")
    ]
    return [script, *BESIDE.get(script, []), *(parts or PROGRAM), f":(exclude){VERSION_FILE}"]


class History:
    """Of the repository, as far as it is there."""

    def version_at(self, commit):
        """None where HEAD does not descend from the commit: what else lies about here, left by
        another branch, is in no clone."""
        if git("merge-base", "--is-ancestor", commit, "HEAD") is None:
            return None
        text = git("show", f"{commit}:{VERSION_FILE}")
        return VERSION.search(text).group(1) if text else None

    def changed_since(self, commit, paths):
        return bool((git("diff", "--name-only", commit, "HEAD", "--", *paths) or "").strip())

    def complete(self):
        return git("rev-parse", "--is-shallow-repository") == "false\n"


def problems_of(text, history):
    """What is wrong with a generated block at any time."""
    stamps = stamps_of(text)
    if not stamps or "commit not recorded" in text:
        yield "says of no commit that it was made of it; run its script again (make bench)"
    for script, _, commit in dict.fromkeys(stamps):
        if history.version_at(commit) is None:
            yield f"was made by {script} of commit {commit}, which the history lacks"


def outdated_by(text, version, history):
    """What of a generated block a release must not hand out."""
    for script, _, commit in dict.fromkeys(stamps_of(text)):
        of_commit = history.version_at(commit)
        if of_commit not in (None, version) and history.changed_since(commit, sources_of(script)):
            yield (
                f"was made by {script} of version {of_commit} (commit {commit}), and its sources"
                " have changed since"
            )


def not_remade(script, makers):
    """Whether a script is missing from those that `make bench` runs."""
    return not re.search(rf"^ *measure {re.escape(script)}\b", makers, re.M)


def blocks_of(page):
    return [(name, text) for name, text in BLOCK.findall(page) if name not in COMPARED]


def is_dated(changelog, version):
    """Whether a changelog says when a version came out."""
    return bool(re.search(rf"^## \[{re.escape(version)}\] - \d", changelog, re.M))


def check(is_release=False):
    """(problems, {why: how many tables could not be judged}); is_release: dated or not."""
    makers = (ROOT / "bench/figures.sh").read_text(encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    version = VERSION.search((ROOT / VERSION_FILE).read_text(encoding="utf-8")).group(1)
    history = History()
    judge = history.complete()
    is_release = is_release or is_dated(changelog, version)
    problems, unjudged = [], collections.Counter()
    for page in PAGES:
        for name, text in blocks_of(page.read_text(encoding="utf-8")):
            where = f"{page.relative_to(ROOT)} ({name})"
            problems += [
                f"{where}: `make bench` does not run {script}"
                for script, _, _ in stamps_of(text)
                if not_remade(script, makers)
            ]
            if not judge:
                unjudged["the history of this repository is not here"] += 1
            elif not stamps_of(text):
                unjudged["they name no commit"] += 1
            else:
                outdated = list(outdated_by(text, version, history))
                if outdated and not is_release:
                    unjudged[f"they are of an older version and {version} is not out yet"] += 1
                found = list(problems_of(text, history)) + (outdated if is_release else [])
                problems += [f"{where}: {problem}" for problem in found]
    return problems, unjudged


class InMemory:
    """A history of three commits; src/graph changed after the first, docs after the second."""

    def version_at(self, commit):
        return {"aaaaaaa": "0.1.0", "bbbbbbb": "0.1.0", "ccccccc": "0.2.0"}.get(commit)

    def changed_since(self, commit, paths):
        return commit == "aaaaaaa" and any(path in ("src", "src/graph") for path in paths)


def self_test():
    def made(commit, script="bench/figures.py --only real"):
        machine = {"processor": "a processor", "processors": 2, "load": 0.0}
        return provenance(
            {
                "command": script,
                "version": "loopstone 0.1.0",
                "commit": commit,
                "changed": ["src/a.cpp"],
                "date": "2026-01-31",
                "machine": machine,
            }
        )

    def found(text):
        problems = [*problems_of(text, InMemory()), *outdated_by(text, "0.2.0", InMemory())]
        return [problem.split(";")[0] for problem in problems]

    assert stamps_of(made("ccccccc")) == [("bench/figures.py", "0.1.0", "ccccccc")], made("ccccccc")
    assert not found(made("ccccccc"))
    assert not found(made("bbbbbbb")), "an older version whose sources stand still"
    assert found(made("aaaaaaa"))[0].endswith(
        "of version 0.1.0 (commit aaaaaaa), and its sources have changed since"
    )
    assert not found(made("aaaaaaa", "bench/ray_cast.py")), "src/graph is no matter to it"
    assert found(made("aaaaaaa", "bench/outliers.py"))
    assert f":(exclude){VERSION_FILE}" in sources_of("bench/figures.py")
    assert "history lacks" in found(made("ddddddd"))[0]
    assert (
        found("| no | stamp |") == found(made("")) == ["says of no commit that it was made of it"]
    )
    assert len(found(made("bbbbbbb") + made(""))) == 1
    assert is_dated("# C\n\n## [0.2.0] - 2026-05-31\n", "0.2.0")
    assert not is_dated("## [0.2.0] - unreleased\n## [0.1.0] - 2026-05-31\n", "0.2.0")
    assert not is_dated("## [Unreleased]\n## [0.2.0.1] - 2026-05-31\n", "0.2.0")
    assert not_remade("bench/a.py", "measure bench/a.pyx\n# measure bench/a.py\n")
    assert not not_remade("bench/a.py", "  measure bench/a.py $quick\n")
    assert blocks_of(
        "<!-- begin: a b -->\n1\n<!-- end: a b -->\n<!-- begin: options -->\n2\n<!-- end:"
        " options -->"
    ) == [("a b", "1\n")]


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return
    if len(sys.argv) > 1:
        sys.exit(__doc__)
    problems, unjudged = check()
    if problems:
        sys.exit("\n".join(problems))
    for reason, tables in unjudged.items():
        print(f"skipped: {tables} tables were not judged, since {reason}")
        if "LOOPSTONE_SKIPPED_TESTS" in os.environ:  # scripts/test.sh counts them
            with open(os.environ["LOOPSTONE_SKIPPED_TESTS"], "a", encoding="utf-8") as file:
                file.write(f"docs\ttables_are_of_this_release\t{tables} tables: {reason}\n")
    if unjudged:
        sys.exit(SKIPPED)


if __name__ == "__main__":
    main()
