"""Pages of the public headers: what a header says of each thing, and how that is declared."""
import pathlib
import re

SUMMARY_PARTS = {
    "base": "Errors, options, threads, random numbers, time stamps.",
    "geometry": "Poses and twists in the plane and in space, covariances.",
    "sensor": "Scans, odometry, IMU, cameras, and the robot that carries them.",
    "devices": "Laser scanners on their wire.",
    "grid": "Grids, distance fields, ray casting.",
    "odometry": "Wheels and gyro to motion; trajectories.",
    "registration": "Scan matching: ICP, correlative search, Gauss-Newton on grids.",
    "mapping": "Occupancy maps, tiles, the floor's texture.",
    "graph": "Pose graphs: solvers, robust kernels, certificate, marginals.",
    "slam": "Front end, loop closing, the mapper, its result and verdict.",
    "localization": "Particle filters, reflectors, relocalisation on a known map.",
    "evaluation": "Errors against the truth.",
    "plan": "Floor plans: a map as lines, rooms and doors.",
    "simulation": "Worlds, sensors and what makes them unkind.",
    "messages": "Messages of ROS 1 and ROS 2, without ROS.",
    "formats": "Logs, maps, graphs and clouds: readers and writers.",
    "pipeline": "A log from its first message to a map, a place on one, or its robot's calibration.",
    "report": "Pictures, pages and files of a result.",
    "live": "The live view, its server, logs that are still written.",
}


def dedented(lines):
    """Without the indentation that all of them have."""
    widths = [len(line) - len(line.lstrip()) for line in lines if line.strip()]
    width = min(widths, default=0)
    return [line[width:] for line in lines]


def declaration_end(lines, begin):
    """The line after a declaration: where its braces and brackets are closed and it ends."""
    depth = 0
    for at in range(begin, len(lines)):
        code = re.sub(r'"(\\.|[^"\\])*"|//.*', "", lines[at])
        depth += sum(code.count(c) for c in "{(") - sum(code.count(c) for c in "})")
        if depth == 0 and re.search(r"[;}]\s*$", code.rstrip()):
            return at + 1
    return len(lines)


def public_part(lines):
    """A class without what is private, a function without its body."""
    shown = []
    for line in lines:
        if re.match(r"\s*(private|protected):", line):
            shown.append("};")
            break
        shown.append(line)
    text = "\n".join(shown)
    is_type = re.match(r"\s*(template\s*<[^{;]*?>\s*)?(class|struct|enum|union)\b", text)
    if not is_type:
        body = re.search(r"\)\s*(const)?\s*(noexcept)?\s*(->[^{]*)?\{", text)
        if body and not re.match(r"\s*(inline )?constexpr \w+(<.*>)? \w+\s*[{=]", text):
            shown = [text[: body.end() - 1].rstrip() + ";"]
    return shown


def name_of(code):
    """Of what is declared."""
    text = " ".join(code.split())
    text = re.sub(r"^template <[^>]*(<[^>]*>[^>]*)*> ", "", text)
    found = re.match(r"(?:class|struct|enum class|enum|union) (\w+)", text)
    if found:
        return found.group(1)
    found = re.match(r"using (\w+)", text) or re.match(r"(?:inline )?constexpr [\w:<>, ]+? (\w+)\s*[={;]", text)
    if found:
        return found.group(1)
    found = re.search(r"([~\w]+|operator[^\s(]+)\s*\(", text)
    return found.group(1) if found else ""


def entities_of(text):
    """(name, comment lines, declaration lines) of what has a comment, at the level of a namespace;
    and of structures of options, which explain themselves."""
    lines = text.splitlines()
    comment, at = [], 0
    while at < len(lines):
        line = lines[at]
        if line.startswith("///"):
            comment.append(line[3:].removeprefix(" "))
            at += 1
            continue
        if not line.strip() or re.match(r"(#|//|namespace |}\s*//|using namespace)", line) or line == "}":
            comment = []
            at += 1
            continue
        end = declaration_end(lines, at)
        # A template's head may stand in a line of its own.
        code = lines[at:end]
        name = name_of("\n".join(code))
        is_told = comment or re.match(r"(struct|class) \w+(Options|Numbers)\b", line)
        if name and is_told and not line.startswith("class " + name + ";"):
            yield name, comment, public_part(code)
        comment, at = [], end


def prose(comment):
    """Markdown of a comment: what is indented by two or more is code, \\param and \\return are lists."""
    out, code = [], []

    def flush():
        if code:
            out.extend(["", "```cpp", *dedented(code), "```", ""])
            code.clear()

    for line in comment:
        if re.match(r"  +\S", line) and (code or not out or not out[-1].startswith(("- ", "    "))):
            code.append(line)
            continue
        if code and not line.strip():
            code.append("")
            continue
        flush()
        tag = re.match(r"\\(param|return)\s*(\w+)?\s*(.*)", line)
        if tag and tag.group(1) == "param":
            if out and not out[-1].startswith("- "):
                out.append("")
            out.append(f"- `{tag.group(2)}`: {escaped(tag.group(3))}")
        elif tag:
            if out and not out[-1].startswith("- "):
                out.append("")
            out.append(f"- returns {escaped((tag.group(2) or '') + ' ' + tag.group(3))}")
        else:
            text = line.strip() if not line.startswith("  - ") else line
            out.append(("    " if out and out[-1].startswith("- ") and line.startswith("  ") else "") + escaped(text))
    flush()
    return "\n".join(out).strip()


def escaped(text):
    """What Markdown would take for its own."""
    return re.sub(r"([*_<>\[\]|])", r"\\\1", text) if "`" not in text else text


def part_page(folder):
    part = folder.name
    out = [f"# loopstone/{part}", "", SUMMARY_PARTS[part], ""]
    for header in sorted(folder.glob("*.hpp")):
        entities = list(entities_of(header.read_text(encoding="utf-8")))
        if not entities:
            continue
        out += [f"## {header.name} {{ #{header.stem} }}", "", f"`#include <loopstone/{part}/{header.name}>`", ""]
        for name, comment, code in entities:
            out += [f"### {escaped(name)} {{ #{header.stem}-{re.sub(r'[^a-z0-9]', '', name.lower())} }}", ""]
            if comment:
                out += [prose(comment), ""]
            out += ["```cpp", *code, "```", ""]
    return "\n".join(out)


def write_header_pages(include, out):
    """A page for each part below `include`, and one that lists them. Returns their names."""
    out.mkdir(parents=True, exist_ok=True)
    parts = [part for part in SUMMARY_PARTS if (include / part).is_dir()]
    unknown = {one.name for one in include.iterdir() if one.is_dir()} - set(parts)
    if unknown:
        raise SystemExit(f"site/header_pages.py has no words for: {sorted(unknown)}")
    index = ["# The C++ library", "", "By part, in the order in which they build on each other; a part knows the ones before it alone.", ""]
    index += ["| part | what |", "| --- | --- |"]
    for part in parts:
        (out / f"{part}.md").write_text(part_page(include / part), encoding="utf-8")
        index.append(f"| [{part}]({part}.md) | {SUMMARY_PARTS[part]} |")
    (out / "index.md").write_text("\n".join(index) + "\n", encoding="utf-8")
    return parts


if __name__ == "__main__":
    root = pathlib.Path(__file__).resolve().parent.parent
    write_header_pages(root / "include/loopstone", root / "build/site/pages/api")
