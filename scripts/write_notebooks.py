#!/usr/bin/env python3
"""Runs the notebooks of examples/notebooks and writes them with what they showed.

What is edited is NAME.py: cells begin with `# %%`, those of text with `# %% [markdown]`. NAME.ipynb
is written from it, so that a reader sees the pictures without running anything; it holds nothing
that changes from run to run. Needs the package and loopstone[notebooks]; scripts/test_python.sh
makes both in build/python.

  build/python/venv/bin/python scripts/write_notebooks.py [NAME...]   runs and writes them (all)
  ... scripts/write_notebooks.py --check [NAME...]
        runs them in a temporary folder, compares cells and printed text with what is committed
"""
import argparse
import base64
import difflib
import io
import os
import pathlib
import re
import sys
import tempfile
import time

import nbclient
import nbformat
from nbformat import v4
from PIL import Image

FOLDER = pathlib.Path(__file__).resolve().parent.parent / "examples" / "notebooks"
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"file_extension": ".py", "name": "python"},
}


def cells_of(text):
    """Of a source, ("markdown" or "code", text) each."""
    parts = re.split(r"^# %%(.*)\n", text, flags=re.M)[1:]
    for mark, body in zip(parts[::2], parts[1::2]):
        body = body.strip("\n")
        if mark.strip() == "[markdown]":
            yield "markdown", re.sub(r"^# ?", "", body, flags=re.M)
        else:
            yield "code", body


def notebook_of(path):
    """A source as a notebook without outputs."""
    make = {"markdown": v4.new_markdown_cell, "code": v4.new_code_cell}
    cells = [
        make[kind](text, id=f"cell-{number:02}")
        for number, (kind, text) in enumerate(cells_of(path.read_text(encoding="utf-8")), 1)
    ]
    return v4.new_notebook(cells=cells, metadata=METADATA)


def small_png(data):
    """The same picture without transparency and with 32 steps a colour, which nobody sees."""
    picture = Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")
    picture = picture.point(lambda value: value & 0xF8 | value >> 5)
    if picture.getcolors(256):
        picture = picture.quantize(256, dither=Image.Dither.NONE)
    out = io.BytesIO()
    picture.save(out, "PNG", optimize=True)
    return base64.b64encode(out.getvalue()).decode() + "\n"


def tidy_outputs(cell):
    """One output for what was printed, however it came in pieces; small pictures."""
    outputs = []
    for output in cell.outputs:
        if output.output_type == "stream" and outputs and outputs[-1].get("name") == output.name:
            outputs[-1].text += output.text
            continue
        data = output.get("data", {})
        if "image/png" in data:
            data["image/png"] = small_png(data["image/png"])
        output.pop("transient", None)
        outputs.append(output)
    cell.outputs = outputs
    cell.metadata.pop("execution", None)


def run(path):
    """The notebook of a source with its outputs; raises nbclient's CellExecutionError."""
    notebook = notebook_of(path)
    with tempfile.TemporaryDirectory() as folder:
        for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR"):
            os.environ[name] = folder  # nobody's own settings
        work = pathlib.Path(folder, "work")
        work.mkdir()
        resources = {"metadata": {"path": str(work)}}
        nbclient.NotebookClient(
            notebook,
            timeout=300,
            resources=resources,
            extra_arguments=["--IPKernelApp.log_level=40"],
        ).execute()
    for cell in notebook.cells:
        if cell.cell_type == "code":
            tidy_outputs(cell)
    # It may have learned more of the kernel than the next machine's will tell.
    notebook.metadata = v4.new_notebook(metadata=METADATA).metadata
    return notebook


def printed(notebook):
    """Cells with what they printed, without pictures: what has to be the same on every machine."""
    lines = []
    for cell in notebook.cells:
        lines += [f"# {cell.id}, {cell.cell_type}", *cell.source.splitlines()]
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            text = (
                output.get("text", "")
                if output.output_type == "stream"
                else data.get("text/plain", "")
            )
            lines += [
                f"# {cell.id}, {output.output_type} {output.get('name', '')}",
                *text.splitlines(),
            ]
    return lines


def faults_of(notebook):
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if output.output_type == "error":
                yield f"{cell.id}: {output.ename}: {output.evalue}"
            if output.get("name") == "stderr":
                yield f"{cell.id} complains: {output.text}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("names", nargs="*", metavar="NAME", help="such as 01_first_map")
    wanted = parser.parse_args()
    names = wanted.names or sorted(path.stem for path in FOLDER.glob("*.py"))
    problems = 0
    for name in names:
        source, target = FOLDER / f"{name}.py", FOLDER / f"{name}.ipynb"
        begin = time.monotonic()
        notebook = run(source)
        took = time.monotonic() - begin
        faults = list(faults_of(notebook))
        if wanted.check:
            committed = nbformat.read(target, as_version=4)
            faults += difflib.unified_diff(
                printed(committed), printed(notebook), "committed", "run now", lineterm="", n=2
            )
        elif not faults:
            nbformat.validate(notebook)
            target.write_text(nbformat.writes(notebook, indent=1) + "\n", encoding="utf-8")
        if faults:
            problems += 1
            print("\n".join([f"{name}:", *faults]))
            if wanted.check:
                print(f"if that is meant: scripts/write_notebooks.py {name}")
        else:
            print(f"{name}: {took:.1f} s, {target.stat().st_size / 1000:.0f} kB")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
