"""Every notebook is stored without outputs and runs from top to bottom."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))
KERNEL = "this-interpreter"

# Jupyter's own, on some of its versions and systems: old calls into asyncio and zmq.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::DeprecationWarning:jupyter_client"),
    pytest.mark.filterwarnings("ignore::RuntimeWarning:zmq"),
]


@pytest.fixture
def kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name a kernel that is the interpreter of this test, whatever else is installed."""
    folder = tmp_path / "jupyter" / "kernels" / KERNEL
    folder.mkdir(parents=True)
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    spec = {"argv": command, "display_name": KERNEL, "language": "python"}
    (folder / "kernel.json").write_text(json.dumps(spec), encoding="utf-8")
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path / "jupyter"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    root = str(Path(__file__).parents[2])
    monkeypatch.setenv("PYTHONPATH", root, prepend=":" if sys.platform != "win32" else ";")
    return KERNEL


def code_cells(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def test_there_are_notebooks():
    assert [path.name for path in NOTEBOOKS] == ["loop_design.ipynb"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_is_stored_without_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert set(notebook.metadata) <= {"kernelspec", "language_info"}
    for cell in code_cells(notebook):
        assert not cell.outputs
        assert cell.execution_count is None
        assert not cell.metadata


def test_loop_design(kernel, tmp_path):
    (path,) = (path for path in NOTEBOOKS if path.stem == "loop_design")
    notebook = nbformat.read(path, as_version=4)
    resources = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=60, kernel_name=kernel, resources=resources).execute()

    outputs = [output for cell in code_cells(notebook) for output in cell.outputs]
    text = "".join(output.text for output in outputs if output.output_type == "stream")
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 6
    assert not [output for output in outputs if output.get("name") == "stderr"]

    def number(pattern: str) -> float:
        match = re.search(pattern.replace("#", r"([\d.]+(?:e[-+]?\d+)?)"), text)
        assert match, f"no {pattern!r} in:\n{text}"
        return float(match[1])

    assert number("crossover +# Hz") == pytest.approx(125.0)
    assert number("phase margin +# deg") == pytest.approx(50.0)
    assert number("FMU and python-control: # m/s") < 1e-9
    assert number("= # % of the step") < 0.01
    without, with_compensation = (
        number(rf"{label} compensation +largest difference from the prediction # mm/s")
        for label in ("without", "with")
    )
    assert with_compensation < 0.1 * without
    without, with_compensation = (
        number(rf"{label} compensation +error # mm/s at most") for label in ("without", "with")
    )
    assert with_compensation < 0.2 * without
    assert number("nothing quantised error # µm/s at most") < 10.0
    assert number("without friction +differs from the design by # % at most") < 0.01
    assert number("with friction, 2 mm/s +differs from the design by # % at most") > 30.0
    assert number("linear axis and python-control: # m/s") < 1e-12
    assert number(r"at rest expected -#, .* found") == pytest.approx(
        number(r"at rest expected .* found -#, "), rel=1e-3
    )
    assert number(r"sliding expected .* found -[\d.]+, -#, ") == pytest.approx(1.19)
