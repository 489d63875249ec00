"""Pages of the notebooks: text, code, what it printed, and pictures, as they are committed."""

import base64
import json
import re


def write_notebook_pages(folder, out):
    """A page beside its pictures and the notebook itself, of each notebook in a folder."""
    out.mkdir(parents=True)
    for path in sorted(folder.glob("*.ipynb")):
        text = path.read_text(encoding="utf-8")
        (out / path.name).write_text(text, encoding="utf-8")
        page = notebook_page(path.stem, json.loads(text)["cells"], out)
        (out / f"{path.stem}.md").write_text(page, encoding="utf-8")


def notebook_page(name, cells, out):
    lines, heading, pictures = [], "", 0
    for number, cell in enumerate(cells):
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            heading = (re.findall(r"^#+ (.*)", source, re.M) or [heading])[-1]
            # From examples/notebooks to where pages of docs/ are in the site.
            lines += [source.replace("](../../docs/", "](../"), ""]
            if number == 0:
                lines += [f"To run it: [{name}.ipynb]({name}.ipynb).", ""]
            continue
        lines += ["```python", source, "```", ""]
        for output in cell["outputs"]:
            data = output.get("data", {})
            if "image/png" in data:
                pictures += 1
                picture = f"{name}_{pictures}.png"
                (out / picture).write_bytes(base64.b64decode("".join(data["image/png"])))
                lines += [f"![Picture: {heading}]({picture})", ""]
            elif "text" in output:
                lines += ["```text", "".join(output["text"]).rstrip(), "```", ""]
    return "\n".join(lines)
