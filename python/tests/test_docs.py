"""Every block of code in docs/python.md does what it says, one after the other."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import loopstone as ls

PAGE = Path(__file__).resolve().parents[2] / "docs" / "python.md"


def blocks() -> list[tuple[int, str]]:
    """The line where each begins, and its text."""
    text = PAGE.read_text()
    found = re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S)
    return [(text[: m.start()].count("\n") + 2, m.group(1)) for m in found]


def test_every_block_runs(
    drive: ls.Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for package in ("matplotlib", "pandas", "networkx", "gtsam"):
        pytest.importorskip(package)
    import matplotlib

    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    drive.save("drive.bag", "bag")
    found = blocks()
    assert len(found) > 12
    names: dict[str, object] = {}
    for line, block in found:
        # Padded, so that a traceback tells the line of the page.
        exec(compile("\n" * (line - 1) + block, str(PAGE), "exec"), names)


def test_signatures_named_there_exist() -> None:
    text = PAGE.read_text()
    for name in set(re.findall(r"\bls\.([A-Za-z_]+)", text)):
        assert hasattr(ls, name), name
