from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

import loopstone as ls

HEAVY = ("numpy", "matplotlib", "pandas", "networkx", "gtsam", "tqdm")


def test_import_brings_nothing_heavy() -> None:
    script = "import sys, loopstone; print(*sorted(set(sys.argv[1:]) & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script, *HEAVY], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == []


def test_the_version_is_that_of_the_program(run: Any) -> None:
    assert ls.__version__ in run("--version").stdout
    try:
        assert metadata.version("loopstone") == ls.__version__
    except metadata.PackageNotFoundError:
        pytest.skip("the package is tried in place")


def undocumented(name: str, public: object) -> Iterator[str]:
    """Of a name and, if it is a class, of what is public in it."""
    if not (public.__doc__ or "").strip():
        yield name
    if isinstance(public, type):
        for inner, value in vars(public).items():
            if not inner.startswith("_") and not (value.__doc__ or "").strip():
                yield f"{name}.{inner}"


def test_what_is_exported_is_documented() -> None:
    aliases = {"__version__", "Message", "MapLike", "ProgressLike"}
    named = {name: getattr(ls, name) for name in ls.__all__ if name not in aliases}
    assert [at for name, public in named.items() for at in undocumented(name, public)] == []
    assert "open_log" in ls.__all__ and "Any" not in ls.__all__

    class Silent:
        """Of which a part says nothing."""

        def part(self) -> None:
            ...

    assert list(undocumented("Silent", Silent)) == ["Silent.part"]


def test_the_stub_in_the_sources_is_that_of_the_extension() -> None:
    """It is where the documentation site takes docstrings from, without a build."""
    built = Path(ls.__file__).parent / "_core.pyi"
    kept = Path(__file__).resolve().parents[1] / "bindings" / "_core.pyi"
    text = re.sub(r"^(version: str) = .*", r"\1", built.read_text(), flags=re.M)
    assert kept.read_text() == text, f"differs from {built}: scripts/write_python_stub.sh"


def test_the_package_is_typed() -> None:
    folder = Path(ls.__file__).parent
    assert (folder / "py.typed").exists()
    stub = (folder / "_core.pyi").read_text()
    assert "class MapResult" in stub and "nanobind" not in stub


def test_the_program_comes_with_it(program: str) -> None:
    by_module = subprocess.run(
        [sys.executable, "-m", "loopstone", "--version"], capture_output=True, text=True
    )
    if by_module.returncode != 0 and "not where it should be" in by_module.stderr:
        pytest.skip("the package is tried in place")
    direct = subprocess.run([program, "--version"], capture_output=True, text=True)
    assert by_module.stdout == direct.stdout
    bad = subprocess.run([sys.executable, "-m", "loopstone", "map"], capture_output=True, text=True)
    assert bad.returncode == 2


def test_results_say_what_they_are(result: ls.MapResult, drive: ls.Simulation) -> None:
    assert repr(result).startswith("<MapResult of ")
    assert repr(drive) == f"<Simulation of {drive.scans} scans>"
    assert str(result.verdict).startswith(result.verdict.overall)
    assert result.robot.to_toml()
