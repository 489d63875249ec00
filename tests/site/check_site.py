#!/usr/bin/env python3
"""Holds the documentation site against what a reader may expect: every link and anchor leads
somewhere, nothing is loaded from elsewhere, pictures have words, pages have titles; every public
name of the Python package has its place, and so has every option.

  tests/site/check_site.py [build/site/html]
"""
import ast
import html.parser
import pathlib
import sys
import urllib.parse

PACKAGE = pathlib.Path(__file__).resolve().parent.parent.parent / "python/loopstone"


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.ids, self.mute, self.title = [], [], set(), [], ""
        self.is_title = False
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        has = dict(attributes)
        if has.get("id"):
            self.ids.add(has["id"])
        if tag == "a" and has.get("href"):
            self.links.append(has["href"])
        if tag == "link" and has.get("rel") in ("stylesheet", "icon", "preconnect"):
            self.loaded.append(has.get("href", ""))
        if tag in ("script", "img", "iframe") and has.get("src"):
            self.loaded.append(has["src"])
        if tag == "img" and not has.get("alt"):
            self.mute.append(has.get("src"))
        self.is_title = tag == "title"

    def handle_data(self, data):
        if self.is_title:
            self.title += data

    def handle_endtag(self, tag):
        self.is_title = False


def python_places():
    """Every name that the package gives out, every class of options of a call, and its groups."""
    (names,) = [
        ast.literal_eval(node.value)
        for node in ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    ]
    yield from (name for name in names if name not in ("__version__", "options"))
    classes = {
        node.name: node
        for node in ast.parse((PACKAGE / "options.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.ClassDef)
    }

    def groups(node, path):
        for field in node.body:
            if isinstance(field, ast.AnnAssign) and ast.unparse(field.annotation) in classes:
                inner = f"{path}.{ast.unparse(field.target)}"
                yield inner
                yield from groups(classes[ast.unparse(field.annotation)], inner)

    for name, node in classes.items():
        if ast.unparse(node.bases[0]) == "CallOptions":
            yield name
            yield from groups(node, name)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/site/html").resolve()
    pages = {path: Page(path) for path in sorted(root.rglob("*.html"))}
    problems, links = [], 0
    for path, page in pages.items():
        name = path.relative_to(root)
        if not page.title.strip():
            problems.append(f"{name}: no title")
        problems += [f"{name}: {src} has no words" for src in page.mute]
        for src in page.loaded:
            if urllib.parse.urlparse(src).scheme in ("http", "https") or src.startswith("//"):
                problems.append(f"{name}: loads {src}")
        for link in page.links:
            parsed = urllib.parse.urlparse(link)
            if parsed.scheme or link.startswith("//"):
                continue
            links += 1
            # The page for what is not found is shown under any address.
            base = root if path.name == "404.html" else path.parent
            target = (
                path
                if not parsed.path
                else (base / urllib.parse.unquote(parsed.path).lstrip("/")).resolve()
            )
            if target.is_dir():
                target /= "index.html"
            if not target.exists():
                problems.append(f"{name}: {link} leads nowhere")
            elif parsed.fragment and target in pages and parsed.fragment not in pages[target].ids:
                problems.append(f"{name}: {link}: no such place there")
    told = {
        place
        for path, page in pages.items()
        if path.parent.name == "python_api"
        for place in page.ids
    }
    missing = [place for place in python_places() if place not in told]
    problems += [f"python_api: nothing of loopstone's {place}" for place in missing]
    for problem in problems[:50]:
        print(problem)
    print(f"{len(pages)} pages, {links} links, {len(problems)} problems")
    return 1 if problems or len(pages) < 40 else 0


if __name__ == "__main__":
    sys.exit(main())
