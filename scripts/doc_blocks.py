"""Generated parts of hand-written pages: what stands between `<!-- begin: NAME -->` and `<!-- end:
NAME -->`."""
import pathlib
import re


def markers(name):
    return f"<!-- begin: {name} -->", f"<!-- end: {name} -->"


def pattern(name):
    begin, end = markers(name)
    return re.compile(re.escape(begin) + r"\n(.*?)" + re.escape(end), re.S)


def read_block(path, name):
    """The text of a block, or None when the page has no such block."""
    found = pattern(name).search(pathlib.Path(path).read_text(encoding="utf-8"))
    return found.group(1) if found else None


def write_block(path, name, text):
    """Replaces a block's text. The page must have the block. Returns whether anything changed."""
    path = pathlib.Path(path)
    page = path.read_text(encoding="utf-8")
    begin, end = markers(name)
    if not pattern(name).search(page):
        raise SystemExit(f"{path}: has no block '{begin}'")
    changed = pattern(name).sub(lambda _: f"{begin}\n{text.rstrip()}\n{end}", page)
    if changed == page:
        return False
    path.write_text(changed, encoding="utf-8")
    return True


def table(header, rows):
    """A Markdown table. Cells are strings; a column whose header ends in '>' is right-aligned."""
    names = [name.rstrip(">") for name in header]
    rule = ["---:" if name.endswith(">") else "---" for name in header]
    lines = [names, rule, *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
