"""Notebooks do what is committed of them: same cells, same printed text, pictures, no errors."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
MOST_BYTES = 400_000

each = pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: str(path.stem))


def cells_of(notebook: Path) -> list[dict[str, Any]]:
    cells: list[dict[str, Any]] = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return cells


def outputs_of(notebook: Path) -> list[dict[str, Any]]:
    return [output for cell in cells_of(notebook) for output in cell.get("outputs", [])]


def test_each_has_its_source() -> None:
    sources = (ROOT / "examples" / "notebooks").glob("*.py")
    assert [path.stem for path in NOTEBOOKS] == sorted(path.stem for path in sources)
    assert len(NOTEBOOKS) >= 5


@each
def test_it_is_small_and_whole(notebook: Path) -> None:
    assert notebook.stat().st_size < MOST_BYTES
    outputs = outputs_of(notebook)
    assert not [o for o in outputs if o["output_type"] == "error" or o.get("name") == "stderr"]
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= 2
    code = ["".join(c["source"]) for c in cells_of(notebook) if c["cell_type"] == "code"]
    assert sum("assert" in text for text in code) >= 2


@each
def test_it_tells_nothing_of_the_machine(notebook: Path) -> None:
    for cell in cells_of(notebook):
        assert set(cell["metadata"]) <= {"tags"}
    for output in outputs_of(notebook):
        text = "".join(output.get("text", []) or output.get("data", {}).get("text/plain", []))
        assert str(ROOT) not in text
        assert not re.search(r"/tmp/|/home/|/root/|0x[0-9a-f]{6,}", text), text


@each
def test_links_lead_somewhere(notebook: Path) -> None:
    for cell in cells_of(notebook):
        if cell["cell_type"] == "markdown":
            for target in re.findall(r"\]\(([^)#\s]+)", "".join(cell["source"])):
                assert (notebook.parent / target).exists(), target


@each
def test_it_runs_and_shows_the_same(notebook: Path) -> None:
    for package in ("gtsam", "ipykernel", "matplotlib", "nbclient"):
        pytest.importorskip(package)
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "write_notebooks.py", "--check", notebook.stem],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
