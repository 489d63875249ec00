#!/usr/bin/env python3
"""Holds the tree to what a release must be: one version everywhere, a changelog that tells of it,
the licences of all that is shipped, commands that exist, no registry's host.

  scripts/check_release.py              what must hold at any time, of what build/release has
  scripts/check_release.py --release    and what must hold when the tag is set: the section has a
                                        date, packages and wheel are there, tables are of this
                                        version, all is committed, the tag is free or here
  scripts/check_release.py --self-test  each check finds what it should

--build DIR looks there in place of build/release. CONTRIBUTING.md, Making a release.
"""
import argparse
import datetime
import pathlib
import re
import sys

from program_help import output_of
from provenance import git

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("scripts", "tests/docs", "tests/layering")]

VERSION_FILE = "include/loopstone/version.hpp"
VERSION = re.compile(r'kVersion = "(\d+\.\d+\.\d+)"')
HEADING = re.compile(r"^## (.*)$", re.M)
SECTION = re.compile(r"\[(Unreleased)\]|\[(\d+\.\d+\.\d+)\] - (unreleased|\d{4}-\d\d-\d\d)")
KINDS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
MADE = re.compile(r"<!-- begin: (.+?) -->\n.*?<!-- end: \1 -->", re.S)
REGISTRIES = re.compile(
    r"https?://[\w.-]*(?:pypi|pythonhosted|npmjs|yarnpkg|crates\.io|proxy\.golang|artifactory"
    r"|nexus)[\w.-]*|--(?:extra-)?index-url\b|\bregistry *= *[\"']?https?:|\"resolved\": *\"https?:"
)
# Folders of THIRD_PARTY (tests/layering) that debian_copyright calls otherwise; and of C alone, of
# which no code is compiled in.
CALLED = {"Eigen": "eigen3", "unsupported": "eigen3", "oneapi": "tbb"}
DECLARATIONS_ONLY = {"dds"}
# Which package brings what debian_copyright lists; those of the Python package come with nanobind.
PACKAGES = {
    "eigen3": "libeigen3-dev",
    "boost": "libboost-dev",
    "nlohmann": "nlohmann-json3-dev",
    "CLI": "libcli11-dev",
    "fmt": "libfmt-dev",
    "spdlog": "libspdlog-dev",
    "toml++": "libtomlplusplus-dev",
    "yaml-cpp": "libyaml-cpp-dev",
    "tbb": "libtbb-dev",
    "hwy": "libhwy-dev",
}
OF_PYTHON = {"nanobind", "tsl"}


def read(path):
    return (ROOT / path).read_text(encoding="utf-8")


# ---- one version


def versions_of_build(build):
    """(what, version or None) of what a build says of itself; what was not built is left out."""
    told = [
        ("CMake's package", build / "loopstone-config-version.cmake", r'PACKAGE_VERSION "([^"]+)"'),
        ("pkg-config", build / "loopstone.pc", r"^Version: *(\S+)"),
        ("CPack", build / "CPackConfig.cmake", r'CPACK_PACKAGE_VERSION "([^"]+)"'),
        ("man page", build / "pages/man1/loopstone.1", r'"loopstone ([\d.]+)"'),
    ]
    for what, path, pattern in told:
        if path.exists():
            found = re.search(pattern, path.read_text(encoding="utf-8"), re.M)
            yield f"{what}, {path.name}", found and found.group(1)
    program = build / "bin/loopstone"
    if program.exists():
        yield "loopstone --version", output_of(str(program), "--version").split()[-1]


def versions_of_packages(build):
    """The same of the files that are handed out."""
    names = ["loopstone", "libloopstone-dev"]
    files = [(f"the package {name}", list(build.glob(f"packages/{name}_*.deb"))) for name in names]
    files.append(("the wheel", list((ROOT / "build/python/dist").glob("loopstone-*.whl"))))
    for what, found in files:
        for path in found:
            yield f"{what}, {path.name}", re.search(r"[_-](\d[\d.]*)[_-]", path.name).group(1)
        if not found:
            yield what, None


def other_versions(version, told):
    for what, other in told:
        if other is None:
            yield f"{what}: is not there or has no version"
        elif other != version:
            yield f"{what}: is of {other}, not of {version}"


def repeated(version, name, text):
    """The number stands in VERSION_FILE alone; what was made by a script may tell it."""
    if re.search(rf"(?<![\w.]){re.escape(version)}(?!\w|\.\d)", MADE.sub("", text)):
        yield f"{name}: says {version}; {VERSION_FILE} alone has the number"
    for found in re.findall(r"find_package\(loopstone +\d[\d.]*", text):
        yield f"{name}: {found}): a version that has to be kept up to date"


def tracked(*patterns):
    return (git("ls-files", "--", *patterns) or "").split("\n")[:-1]


def texts():
    """(name, text) of all that is written by hand."""
    left_out = (
        ":!tests",
        ":!fuzz/corpus",
        ":!viewer/built",
        ":!*.lock",
        ":!*lock.json",
        ":!docs/images",
        ":!scripts/check_release.py",
    )
    for name in tracked(".", *left_out):
        if name not in ("CHANGELOG.md", VERSION_FILE):
            try:
                yield name, read(name)
            except UnicodeDecodeError:
                continue


# ---- the changelog


def sections_of(text):
    """(version or "Unreleased" or None, date or None, heading, body), in their order."""
    pieces = HEADING.split(text)[1:]
    for heading, body in zip(pieces[::2], pieces[1::2]):
        found = SECTION.fullmatch(heading)
        yield found and (found.group(1) or found.group(2)), found and found.group(3), heading, body


def entries(body):
    return [line for line in body.splitlines() if line.startswith("- ")]


def wrong_in_changelog(text, version, today, is_release):
    sections = list(sections_of(text))
    for name, date, heading, body in sections:
        if name is None:
            yield f"`## {heading}`: neither `[Unreleased]` nor `[1.2.3] - YYYY-MM-DD`"
        for kind in re.findall(r"^### (.*)$", body, re.M):
            if kind not in KINDS:
                yield f"[{name}]: `### {kind}` is none of {', '.join(sorted(KINDS))}"
        if date not in (None, "unreleased"):
            try:
                if datetime.date.fromisoformat(date) > today:
                    yield f"[{name}]: {date} is not yet"
            except ValueError:
                yield f"[{name}]: {date} is no day"
    names = [name for name, *_ in sections]
    numbers = [tuple(map(int, name.split("."))) for name in names if name and name[0].isdigit()]
    if numbers != sorted(set(numbers), reverse=True):
        yield "versions do not go from the newest to the oldest"
    if "Unreleased" in names[1:]:
        yield "[Unreleased] is not the first section"
    if not sections:
        yield "has no section"
        return
    name, date, _, body = sections[0]
    if is_release and (name != version or date == "unreleased"):
        yield f"the first section is not `[{version}] - YYYY-MM-DD`"
    if name not in ("Unreleased", version):
        yield f"the first section is neither [Unreleased] nor that of {version}"
    if version not in names and "Unreleased" not in names:
        yield f"says nothing of {version}"
    if not entries(body):
        yield f"[{name}] tells nothing"


# ---- licences


def listed_licences(text):
    """{folder of headers: licence} of a Debian copyright file, and the licences with their text."""
    listed, told = {}, set()
    for paragraph in re.split(r"\n\n+", text.strip()):
        licence = re.search(r"^License: *(\S+)", paragraph, re.M)
        files = re.search(r"^Files: *(.*)", paragraph, re.M)
        if files and licence:
            listed |= {
                name: licence.group(1)
                for name in re.findall(r"include-of/([^/]+)/", files.group(1))
            }
        elif licence and re.search(r"^ \S", paragraph, re.M):
            told.add(licence.group(1))
    return listed, told


def wrong_licences(copyright_text, allowed, compiled_in):
    """Every library that sources may include, and whose headers are code, has its licence and its
    text; what the SBOM says was compiled in is the same."""
    listed, told = listed_licences(copyright_text)
    folders = {name.split("/")[0] for name in allowed if "/" in name}
    used = {CALLED.get(name, name) for name in folders} - DECLARATIONS_ONLY
    yield from (f"lacks {name}, which sources may include" for name in sorted(used - set(listed)))
    yield from (
        f"lists {name}, which no source may include"
        for name in sorted(set(listed) - used - OF_PYTHON)
    )
    yield from (f"lacks the text of {licence}" for licence in sorted(set(listed.values()) - told))
    packages = {PACKAGES.get(name, name) for name in set(listed) - OF_PYTHON}
    for name in sorted(packages ^ set(compiled_in)):
        yield f"{name} is either here or in COMPILED_IN of scripts/write_sbom.py, not in both"


# ---- what README says to type


def wrong_commands(text, targets, exists):
    """`make TARGET` and paths of scripts in code; docs.are_true holds commands of the program."""
    for block in re.findall(r"```.*?```|`[^`\n]+`|(?:^    .*\n)+", text, re.S | re.M):
        for target in re.findall(r"(?:^|[`&;] *)\s*make +([a-z-]+)", block, re.M):
            if target not in targets:
                yield f"there is no `make {target}`"
        for path in re.findall(r"(?<![\w/])((?:scripts|tests|bench|\.ci)/[\w./<>*-]+)", block):
            if not re.search("[<>*]", path) and not exists(path.rstrip(".")):
                yield f"there is no {path}"


# ---- the repository


def registries(name, text):
    for found in dict.fromkeys(match.group(0) for match in REGISTRIES.finditer(text)):
        yield f"{name}: names a registry: {found}"


def wrong_repository(version, status, tags_here, tags):
    if status:
        yield f"not committed: {status.splitlines()[0][3:]} and {len(status.splitlines()) - 1} more"
    if f"v{version}" in tags and f"v{version}" not in tags_here:
        yield f"the tag v{version} is on another commit: {VERSION_FILE} needs the next number"


def check(build, is_release):
    import check_layering
    from write_sbom import COMPILED_IN

    version = VERSION.search(read(VERSION_FILE)).group(1)
    found = list(other_versions(version, versions_of_build(build)))
    for name, text in texts():
        found += repeated(version, name, text)
        found += registries(name, text)
    for name in tracked("*.lock", "*lock.json"):
        # Cargo.lock names the index of all its packages, whatever host they came from.
        found += registries(
            name, read(name).replace("registry+https://github.com/rust-lang/crates.io-index", "")
        )
    today = datetime.datetime.now(datetime.timezone.utc).date()
    found += [
        f"CHANGELOG.md: {one}"
        for one in wrong_in_changelog(read("CHANGELOG.md"), version, today, is_release)
    ]
    licences = wrong_licences(
        read("cmake/debian_copyright"), check_layering.THIRD_PARTY, COMPILED_IN
    )
    found += [f"cmake/debian_copyright: {one}" for one in licences]
    targets = set(re.findall(r"^([a-z-]+):", read("Makefile"), re.M))
    for name in ("README.md", "CONTRIBUTING.md"):
        found += [
            f"{name}: {one}"
            for one in wrong_commands(read(name), targets, lambda path: (ROOT / path).exists())
        ]
    if is_release:
        import check_tables

        found += other_versions(version, versions_of_packages(build))
        problems, unjudged = check_tables.check(is_release=True)
        found += problems + [
            f"{tables} tables were not judged: {reason}" for reason, tables in unjudged.items()
        ]
        tags_here, tags = (git("tag", "--points-at", "HEAD") or "").split(), (
            git("tag") or ""
        ).split()
        found += wrong_repository(version, git("status", "--porcelain") or "", tags_here, tags)
    return version, found


def self_test():
    day = datetime.date(2026, 6, 1)

    def changelog(text, version="0.2.0", is_release=False):
        return list(wrong_in_changelog(text, version, day, is_release))

    unreleased = "# C\n\n## [Unreleased]\n\n### Added\n\n- a\n\n"
    unreleased += "## [0.1.0] - 2026-01-31\n\n### Added\n\n- b\n"
    dated = unreleased.replace("[Unreleased]", "[0.2.0] - 2026-05-31")
    assert (
        not changelog(unreleased) and not changelog(dated) and not changelog(dated, is_release=True)
    )
    assert "not `[0.2.0]" in changelog(unreleased, is_release=True)[0]
    assert "tells nothing" in changelog(unreleased.replace("- a", ""))[0]
    assert "is no day" in changelog(dated.replace("05-31", "05-32"))[0]
    assert "is not yet" in changelog(dated.replace("05-31", "07-01"))[0]
    assert "neither" in changelog(dated.replace("- 2026-05-31", "(May 2026)"))[0]
    assert "newest" in changelog(dated.replace("0.1.0", "0.3.0"))[0]
    assert "is none of" in changelog(dated.replace("### Added\n\n- a", "### News\n\n- a"))[0]
    assert "not the first" in changelog(dated + "\n## [Unreleased]\n\n- c\n")[0]
    assert changelog(dated, version="0.3.0") == [
        "the first section is neither [Unreleased] nor that of 0.3.0",
        "says nothing of 0.3.0",
    ]

    assert not list(other_versions("0.2.0", [("a", "0.2.0")]))
    assert len(list(other_versions("0.2.0", [("a", "0.1.0"), ("b", None)]))) == 2
    made = "<!-- begin: t -->\nloopstone 0.2.0\n<!-- end: t -->\n"
    assert not list(repeated("0.2.0", "a.md", made + "10.2.0 0.2.0.1 v20.2.00"))
    assert list(repeated("0.2.0", "a.md", made + "as of 0.2.0.\n"))
    assert list(repeated("0.2.0", "a.md", "find_package(loopstone 0.1 REQUIRED)"))

    paragraph = "Files: include-of/{0}/*\nCopyright: A\nLicense: {1}\n\n"
    text = paragraph.format("fmt", "Expat") + paragraph.format("eigen3", "MPL-2.0")
    texts_of = "License: Expat\n Do.\n\nLicense: MPL-2.0\n Do.\n"
    allowed, compiled = ["fmt/", "Eigen/", "unsupported/Eigen/", "png.h", "dds/"], [
        "libfmt-dev",
        "libeigen3-dev",
    ]
    assert not list(wrong_licences(text + texts_of, allowed, compiled))
    assert list(wrong_licences(text + texts_of, [*allowed, "boost/"], compiled)) == [
        "lacks boost, which sources may include"
    ]
    assert "lists fmt" in list(wrong_licences(text + texts_of, ["Eigen/"], compiled))[0]
    assert (
        "text of MPL-2.0"
        in list(wrong_licences(text + "License: Expat\n Do.\n", allowed, compiled))[0]
    )
    assert (
        "libhwy-dev" in list(wrong_licences(text + texts_of, allowed, [*compiled, "libhwy-dev"]))[0]
    )

    readme = (
        "Run `make demo`, and make sure.\n\n    make bench    # scripts/a.sh\n    tests/b.py -x\n"
    )
    assert not list(wrong_commands(readme, {"demo", "bench"}, lambda path: True))
    assert len(list(wrong_commands(readme, {"demo"}, lambda path: path == "scripts/a.sh"))) == 2

    hosts = [
        "https://registry." + "npmjs.org/a",
        '"resolved": "' + 'https://x/a.tgz"',
        "pip install --index" + "-url x",
    ]
    assert [len(list(registries("a", host))) for host in hosts] == [1, 1, 1]
    assert not list(registries("a", "pip install . from PyPI; see https://semver.org"))

    assert not list(wrong_repository("0.2.0", "", [], ["v0.1.0"]))
    assert not list(wrong_repository("0.2.0", "", ["v0.2.0"], ["v0.2.0"]))
    assert "another commit" in list(wrong_repository("0.2.0", "", [], ["v0.2.0"]))[0]
    assert "not committed" in list(wrong_repository("0.2.0", " M a\n M b\n", [], []))[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument(
        "--release", action="store_true", help="what must hold when the tag is set, too"
    )
    parser.add_argument("--self-test", action="store_true", help="each check finds what it should")
    arguments = parser.parse_args()
    if arguments.self_test:
        self_test()
        return
    version, found = check(arguments.build, arguments.release)
    if found:
        sys.exit("\n".join(found))
    word = "ready to be tagged" if arguments.release else "nothing is in the way of a release"
    print(f"{version}: {word}")


if __name__ == "__main__":
    main()
