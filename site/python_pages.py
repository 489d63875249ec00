"""Pages of the Python package: what the docstrings of its public names say, and how each is called.

Nothing is imported: `python/loopstone` and the stubs of the extension module, which a test holds
against the module itself (python/tests/test_package.py), are read as text.
"""

import ast
import html
import pathlib
import re
import textwrap

# Which page has which name, in the order of docs/python.md; what is in no group is an error.
GROUPS = {
    "logs": (
        "Logs",
        "Messages of a recording, and the robot that made it.",
        "open_log convert Conversion Log LogMessages LogSummary Message LaserScan OdometryPose WheelTicks ImuSample RgbdFrame",
    ),
    "robots": (
        "Robots and calibration",
        "Where sensors sit and how wheels count, told or found out.",
        "Robot LidarMount WheelModel calibrate CalibrationResult CalibratedValue WheelCalibration",
    ),
    "mapping": (
        "Mapping",
        "From a log to a map and a verdict; whole, or while the robot drives.",
        "map MapResult MapVerdict QualityMeasure LoopClosure Mapper MapUpdate MapEvent Progress ProgressLike",
    ),
    "editing": (
        "Editing",
        "A finished map put right by hand.",
        "MapEditor EditReport",
    ),
    "sites": (
        "Sites",
        "One map of a building from many drives.",
        "Site SiteSession SiteMap SiteChanges MapChange SiteTie SiteEvent SiteEdit SitePruning DateLike",
    ),
    "plans": (
        "Floor plans",
        "Walls, rooms and doors of a map.",
        "floor_plan FloorPlan PlanSegment PlanRoom PlanDoor PlanAxis",
    ),
    "maps": (
        "Maps and trajectories",
        "Cells and poses as arrays, and their files.",
        "GridMap OccupancyMap MapLike read_map Trajectory read_trajectory",
    ),
    "localization": (
        "Localisation",
        "Where a robot is on a known map.",
        "localize LocalizationResult LocalizationEstimate LocalizationMap Localizer relocalize Relocalization PlaceCandidate",
    ),
    "landmarks": (
        "Landmarks",
        "Reflectors and beacons, to localise by or found by a map.",
        "Landmark FoundLandmark LandmarksLike read_landmarks",
    ),
    "matching": (
        "Matching",
        "Two scans, two clouds, or a scan and a map.",
        "match MatchResult",
    ),
    "pose_graphs": (
        "Pose graphs",
        "Solved, and proven optimal.",
        "optimize PoseGraph read_graph OptimizeResult Certificate",
    ),
    "evaluation": ("Evaluation", "Errors against the truth.", "evaluate Evaluation ErrorStatistics"),
    "simulation": ("Simulation", "Logs with known truth.", "simulate Simulation world_names realism_names"),
    "poses": ("Poses", "Composed, inverted, points moved.", "Pose"),
    "texture": ("Texture", "The colour of the floor.", "FloorTexture"),
    "errors": (
        "Errors",
        "What is raised, and what it knows.",
        "Error UsageError OptionsError OptionProblem DataError MissingFileError",
    ),
}
ELSEWHERE = {"__version__", "options"}  # on the first page, and on pages of their own
SPECIAL = {"__iter__": "iteration", "__len__": "`len()`", "__bool__": "`bool()`"}
RULE = re.compile(r"\s*\((a (?:whole )?number [^()]*)\)$")


class Package:
    """The public names, each with the file and the tree in which it is told."""

    def __init__(self, folder):
        self.sources, self.trees = {}, {}
        for module in ("__init__", "_api", "_errors", "_option_group", "_progress", "_site", "options"):
            self.read(module, folder / "loopstone" / f"{module}.py")
        self.read("_core", folder / "bindings" / "_core.pyi")
        self.names = names_of_all(self.trees["__init__"])
        self.homes = {
            alias.asname or alias.name: (node.module, alias.name)
            for node in self.trees["__init__"].body
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("_")
            for alias in node.names
        }
        self.pages = {name: page for page, (_, _, names) in GROUPS.items() for name in names.split()}
        wrong = set(self.names) ^ (set(self.pages) | ELSEWHERE)
        if wrong:
            raise SystemExit(f"site/python_pages.py: GROUPS and __all__ differ in {sorted(wrong)}")
        self.calls = {}
        for node in classes(self.trees["options"]):
            if base_of(node) == "CallOptions" or base_of(node) in self.calls:
                self.calls[node.name] = node
        self.pages |= {name: f"options_{page_stem(name)}" for name in self.calls}

    def read(self, module, path):
        self.sources[module] = path.read_text(encoding="utf-8")
        self.trees[module] = ast.parse(self.sources[module], str(path))

    def node(self, name):
        module, inner = self.homes[name]
        for node in self.trees[module.lstrip(".")].body:
            if getattr(node, "name", None) == inner or is_assignment_of(node, inner):
                return module.lstrip("."), node
        raise SystemExit(f"site/python_pages.py: {module} does not define {inner}")

    def linked(self, code):
        """Code as HTML, in which public names lead to their places."""

        def link(match):
            name = match.group(0)
            if name not in self.pages or name in ("map", "match", "optimize", "evaluate", "simulate", "localize"):
                return name
            return f'<a href="{self.pages[name]}.html#{name}">{name}</a>'

        text = re.sub(r"(?<![\w.\"'])[A-Za-z_]\w*", link, html.escape(code, quote=False))
        return f"<code>{text.replace('|', '&#124;')}</code>"

    def prose(self, text):
        """A docstring's reStructuredText, of which a few words are used, as Markdown."""
        pieces = re.split(r"(:\w+:`[^`]+`|``[^`]+``|`[^`]+`)", text)
        for at, piece in enumerate(pieces):
            public = re.fullmatch(r"(?::\w+:`|``)(?:loopstone\.)(?:options\.)?(\w+)`+|:\w+:`(\w+)`", piece)
            name = public and (public.group(1) or public.group(2))
            if name in self.pages:
                pieces[at] = self.named(name)
            elif at % 2:
                pieces[at] = "`" + piece.split("`", 1)[1].strip("`") + "`"
            else:
                plain = re.sub(r"([*_<>\[\]|\\])", r"\\\1", piece)
                pieces[at] = re.sub(r"\b[A-Z]\w*Error\b", lambda found: self.named(found.group(0)), plain)
        return "".join(pieces)

    def named(self, name):
        """As code, which leads to its place if it has one."""
        return f"[`{name}`]({self.pages[name]}.md#{name})" if name in self.pages else f"`{name}`"

    def docstring(self, node):
        """Paragraphs, then what is said of parameters, results and errors as a list."""
        text, items = told(ast.get_docstring(node), getattr(node, "name", "loopstone")), []

        def take(match):
            kind, name, words = match.group(1), match.group(2), " ".join(match.group(3).split())
            if kind == "raises":
                name = f"raises {self.named(name)}"
            items.append(f"- {f'`{name}`' if kind == 'param' else name or 'returns'}: {self.prose(words)}")
            return ""

        field = r"^:(param|raises|return)\s*(\w*):\s*(.*(?:\n[ ]+.*)*)\n?"
        text = re.sub(field, take, text, flags=re.M)
        out = []
        for block in re.split(r"\n\s*\n", text.strip()):
            is_code = block.lstrip().startswith(">>>")
            out += ["```pycon", textwrap.dedent(block), "```", ""] if is_code else [self.prose(" ".join(block.split())), ""]
        return out + items + [""]

    def reference(self, name):
        module, node = self.node(name)
        out = [f"## {name} {{ #{name} }}", ""]
        if isinstance(node, ast.FunctionDef):
            return out + signature(f"loopstone.{name}", node) + self.docstring(node)
        if isinstance(node, ast.ClassDef):
            return out + self.of_class(node)
        return out + [self.prose(comment_above(self.sources[module], node)), "", *code(f"{name} = {shown(node.value)}")]

    def of_class(self, node):
        bases = [shown(base) for base in node.bases if shown(base) not in ("NamedTuple", "Exception")]
        out = self.docstring(node)
        out += [f"It is a kind of {' and of '.join(self.named(base) for base in bases)}.", ""] if bases else []
        functions = [each for each in node.body if isinstance(each, ast.FunctionDef)]
        if any(each.name == "__init__" and ast.get_docstring(each) for each in functions):
            (init,) = [each for each in functions if each.name == "__init__"]
            out += signature(f"loopstone.{node.name}", init) + self.docstring(init)
        attributes = [*attributes_of(node), *(each for each in functions if "property" in decorators(each))]
        if attributes:
            out += table(["attribute", "type", "what"], [self.row(each) for each in attributes])
        uses = [word for special, word in SPECIAL.items() if any(each.name == special for each in functions)]
        if uses:
            out += [f"Works with {' and '.join(uses)}.", ""]
        for each in functions:
            if each.name.startswith("_") or "property" in decorators(each):
                continue
            out += [f"### {node.name}.{each.name} {{ #{node.name}.{each.name} }}", ""]
            prefix = f"{node.name}." if "staticmethod" in decorators(each) else "."
            out += signature(prefix + each.name, each) + self.docstring(each)
        return out

    def row(self, attribute):
        if isinstance(attribute, ast.FunctionDef):
            name, kind, text = attribute.name, attribute.returns, ast.get_docstring(attribute)
        else:
            name, kind, text = attribute
        text = told(text, name)
        return f"`{name}`", self.linked(shown(kind)) if kind else "", self.prose(" ".join(text.split()))


def told(text, name):
    """A docstring, which nothing may lack that is shown."""
    if not text or not text.strip():
        raise SystemExit(f"site/python_pages.py: {name} has no docstring")
    return text


def names_of_all(tree):
    (node,) = [each for each in tree.body if is_assignment_of(each, "__all__")]
    return ast.literal_eval(node.value)


def is_assignment_of(node, name):
    return isinstance(node, ast.Assign) and shown(node.targets[0]) == name


def classes(tree):
    return [node for node in tree.body if isinstance(node, ast.ClassDef)]


def base_of(node):
    return shown(node.bases[0]) if node.bases else ""


def decorators(node):
    return [shown(each) for each in node.decorator_list]


def shown(node):
    """Code as a user would write it."""
    text = ast.unparse(node) if isinstance(node, ast.AST) else node
    text = re.sub(r"Annotated\[(NDArray\[[\w.]+\]), dict\((?:[^()]|\([^()]*\))*\)\]", r"\1", text)
    text = text.replace("numpy.bool_", "bool")
    text = re.sub(r"\b(_core|numpy\.typing|numpy|loopstone\.options)\.", "", text)
    return re.sub(r"'([^'\"]*)'", r'"\1"', text)


def table(head, rows):
    """With names that are not broken, and told row by row on a telephone: site.css."""
    lines = [head, ["---"] * len(head), *rows]
    return ['<div class="reference" markdown>', "", *(f"| {' | '.join(row)} |" for row in lines), "", "</div>", ""]


def code(text):
    return ["```python", text, "```", ""]


def signature(name, node):
    """How something is called; a parameter a line where one line is not enough."""
    given, last = node.args, len(node.args.args) - len(node.args.defaults)
    parameters = []
    for at, each in enumerate(given.args):
        if each.arg not in ("self", "cls"):
            parameters.append(parameter(each, given.defaults[at - last] if at >= last else None))
    if given.vararg:
        parameters.append(f"*{given.vararg.arg}")
    elif given.kwonlyargs:
        parameters.append("*")
    parameters += [parameter(each, value) for each, value in zip(given.kwonlyargs, given.kw_defaults)]
    if given.kwarg:
        parameters.append(f"**{given.kwarg.arg}")
    result = f" -> {shown(node.returns)}" if node.returns and node.name != "__init__" else ""
    line = f"{name}({', '.join(parameters)}){result}"
    if len(line) > 80:
        line = f"{name}(\n    " + ",\n    ".join(parameters) + f",\n){result}"
    return code(line)


def parameter(argument, default):
    kind = f": {shown(argument.annotation)}" if argument.annotation else ""
    return argument.arg + kind + ("" if default is None else f"{' = ' if kind else '='}{shown(default)}")


def attributes_of(node):
    """(name, type, words) of fields, and of what an exception's constructor keeps."""
    (init,) = [each for each in node.body if getattr(each, "name", "") == "__init__"] or [None]
    arguments = {each.arg: each.annotation for each in init.args.args} if init else {}
    for body in (node.body, init.body if init else []):
        for at, each in enumerate(body):
            after = body[at + 1] if at + 1 < len(body) else None
            is_told = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            words = str(after.value.value) if is_told else ""
            if isinstance(each, ast.AnnAssign) and not shown(each.target).startswith("_"):
                yield shown(each.target), each.annotation, words
            elif isinstance(each, ast.Assign) and shown(each.targets[0]).startswith("self.") and is_told:
                name = shown(each.targets[0]).removeprefix("self.")
                yield name, arguments.get(name), words


def comment_above(source, node):
    lines, at, words = source.splitlines(), node.lineno - 2, []
    while at >= 0 and lines[at].startswith("#:"):
        words.insert(0, lines[at][2:].strip())
        at -= 1
    return " ".join(words)


def page_stem(name):
    """Of the options of a call: MatchOptions -> match."""
    return name.removesuffix("Options").lower()


def option_rows(package, fields):
    """The table of options that are no groups."""
    rows = []
    for name, kind, default, words in fields:
        words = " ".join(told(words, name).split())
        rule = RULE.search(words)
        if rule:
            text = re.sub(r"^a number from |^a number ", "", rule.group(1))
            text = re.sub(r"^a whole number from (.*)", r"\1, whole", text)
            words = words[: rule.start()]
        elif shown(kind).startswith("Literal["):
            text = ", ".join(f"`{word}`" for word in ast.literal_eval(shown(kind).removeprefix("Literal")))
        else:
            text = {"bool": "true or false", "str": "text"}.get(shown(kind), "")
        rows.append((f"`{name}`", f"`{shown(default)}`", text, package.prose(words)))
    return table(["option", "default", "range", "what"], rows)


def option_sections(package, of_name, node, prefix=""):
    """A table of each group, with the dotted path by which it is reached."""
    fields, groups = [], []
    known = {each.name: each for each in classes(package.trees["options"])}
    for name, kind, words in attributes_of(node):
        value = next(
            each.value for each in node.body if isinstance(each, ast.AnnAssign) and shown(each.target) == name
        )
        if shown(kind) in known:
            groups.append((name, known[shown(kind)]))
        else:
            fields.append((name, kind, value, words))
    out = option_rows(package, fields) if fields else []
    for name, group in groups:
        path = prefix + name
        out += [f"## {path} {{ #{of_name}.{path} }}", "", f"`{group.name}`, the field `{path}` of `{of_name}`.", ""]
        out += option_sections(package, of_name, group, path + ".")
    return out


def options_page(package, name):
    node = package.calls[name]
    out = [f"# {name} {{ #{name} }}", "", *package.docstring(node)]
    if base_of(node) in package.calls:
        out += [f"All of [{base_of(node)}]({package.pages[base_of(node)]}.md), and:", ""]
    return out + option_sections(package, name, node)


def options_index(package):
    out = ["# Options", "", package.prose(ast.get_docstring(package.trees["options"]).split("\n")[0]), ""]
    out += code("from loopstone.options import MapOptions\n\noptions = MapOptions()\noptions.map.resolution_m = 0.1")
    out += ["Instead of such an object, calls take a mapping of dotted keys, the path of a TOML file, and keywords in", ""]
    out[-2] += " which two underscores stand for the dot: [Python, options](../python.md#options)."
    out += ["| class | options of |", "| --- | --- |"]
    for name, node in package.calls.items():
        words = package.prose((ast.get_docstring(node) or "").removeprefix("Of ").rstrip("."))
        out.append(f"| [{name}]({package.pages[name]}.md) | {words} |")
    out += ["", "All of them have:", ""]
    for node in classes(package.trees["_option_group"]):
        for each in node.body:
            if isinstance(each, ast.FunctionDef) and not each.name.startswith("_"):
                out += [f"## {each.name} {{ #{each.name} }}", "", *signature(f".{each.name}", each)]
                out += package.docstring(each)
    return out


def index_page(package):
    out = ["# The Python package", "", *package.docstring(package.trees["__init__"])]
    out += ["`loopstone.__version__` is that of the library. [Loopstone from Python](../python.md) tells how it is used.", ""]
    out += ["| page | what | names |", "| --- | --- | --- |"]
    for page, (title, words, names) in GROUPS.items():
        if page == "errors":
            out.append(f"| [Options](options.md) | Defaults, ranges, meaning. | {linked_names(package, package.calls)} |")
        out.append(f"| [{title}]({page}.md) | {words} | {linked_names(package, names.split())} |")
    return out


def linked_names(package, names):
    return ", ".join(package.named(name) for name in names)


def write_python_pages(folder, out):
    """The pages of the package in `folder`, the repository's python/."""
    package = Package(folder)
    pages = {"index": index_page(package), "options": options_index(package)}
    for page, (title, words, names) in GROUPS.items():
        pages[page] = [f"# {title}", "", words, ""]
        for name in names.split():
            pages[page] += package.reference(name)
    for name in package.calls:
        pages[package.pages[name]] = options_page(package, name)
    out.mkdir(parents=True, exist_ok=True)
    for page, lines in pages.items():
        (out / f"{page}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    root = pathlib.Path(__file__).resolve().parent.parent
    write_python_pages(root / "python", root / "build/site/pages/python_api")
