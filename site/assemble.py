#!/usr/bin/env python3
"""Puts the pages of the site together in build/site/pages: those of docs/, the public headers, the
Python package, the examples, the notebooks, and a start page. Links that lead out of docs/ are led to where their
targets are here.

  site/assemble.py
"""
import pathlib
import re
import shutil
import sys

from header_pages import write_header_pages
from notebook_pages import write_notebook_pages
from python_pages import write_python_pages

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = ROOT / "build/site/pages"
# Of the source tree alone; docs/README.md is what the site's navigation is.
LEFT_OUT = {"README.md"}
OTHERS = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}


def target_of(link, parts):
    """Where a link of a page in docs/, or of one beside it, leads to in the site."""
    path, _, anchor = link.partition("#")
    anchor = f"#{anchor}" if anchor else ""
    name = path.removeprefix("../").removeprefix("docs/")
    if name in OTHERS:
        return OTHERS[name] + anchor
    if name in ("README.md", "LICENSE"):
        return "index.md"
    if name == "include/loopstone":
        return "api/index.md"
    if name == "python/loopstone":
        return "python_api/index.md"
    if name == "python/loopstone/options.py":
        return "python_api/options.md"
    found = re.fullmatch(r"include/loopstone/(\w+)(?:/(\w+)\.hpp)?", name)
    if found and found.group(1) in parts:
        return f"api/{found.group(1)}.md" + (f"#{found.group(2)}" if found.group(2) else "")
    found = re.fullmatch(r"examples/(\w+)\.cpp", name)
    if found:
        return f"examples.md#{found.group(1)}"
    found = re.fullmatch(r"examples/notebooks(?:/(\w+)\.ipynb)?", name)
    if found:
        return f"notebooks/{found.group(1) or '01_first_map'}.md"
    if (ROOT / name).is_file() and path.startswith("../"):
        return f"files/{name}"
    return name + anchor


def assembled(text, parts, files):
    def led(match):
        link = match.group(2)
        if re.match(r"\w+:|#", link):
            return match.group(0)
        target = target_of(link, parts)
        if target.startswith("files/"):
            files.add(target.removeprefix("files/"))
        return f"]({target})"

    # Not in code.
    pieces = re.split(r"(^```.*?^```|^(?:    [^\n]*\n)+)", text, flags=re.M | re.S)
    pieces[::2] = [re.sub(r"\]()\(([^)\s]+)\)", led, piece) for piece in pieces[::2]]
    return "".join(pieces)


def examples_page():
    out = ["# Examples", "", "Programs to copy from; the tests build and run them.", ""]
    for path in sorted((ROOT / "examples").glob("*.cpp")):
        out += [f"## {path.name} {{ #{path.stem} }}", "", "```cpp", path.read_text().rstrip(), "```", ""]
    return "\n".join(out)


def main():
    shutil.rmtree(PAGES, ignore_errors=True)
    PAGES.mkdir(parents=True)
    parts = write_header_pages(ROOT / "include/loopstone", PAGES / "api")
    write_python_pages(ROOT / "python", PAGES / "python_api")
    write_notebook_pages(ROOT / "examples/notebooks", PAGES / "notebooks")
    shutil.copytree(ROOT / "docs/images", PAGES / "images")
    for path in (ROOT / "site/pages").iterdir():
        shutil.copy(path, PAGES / path.name)
    sources = {path.name: path for path in (ROOT / "docs").glob("*.md") if path.name not in LEFT_OUT}
    sources |= {name: ROOT / source for source, name in OTHERS.items()}
    files = set()
    for name, path in sources.items():
        text = assembled(path.read_text(encoding="utf-8"), parts, files)
        (PAGES / name).write_text(text, encoding="utf-8")
    (PAGES / "examples.md").write_text(examples_page(), encoding="utf-8")
    for name in files:
        (PAGES / "files" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, PAGES / "files" / name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
