"""Executes notebooks: ``python -m tests.stored_notebooks [NAME ...]`` stores their outputs.

Outputs are stored without what differs from run to run: times, and numbers of executions.
"""

import json
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
LONGEST = 600
"""Of a cell [s]."""
_KERNEL = "this-interpreter"


@contextmanager
def _kernel(folder: Path) -> Iterator[None]:
    """Make a kernel that is this interpreter, whatever else is installed."""
    kernel = folder / "jupyter" / "kernels" / _KERNEL
    kernel.mkdir(parents=True)
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    spec = {"argv": command, "display_name": _KERNEL, "language": "python"}
    (kernel / "kernel.json").write_text(json.dumps(spec), encoding="utf-8")
    path = os.environ.get("PYTHONPATH")
    changed = {
        "JUPYTER_PATH": str(folder / "jupyter"),
        "JUPYTER_RUNTIME_DIR": str(folder / "runtime"),
        "JUPYTER_PLATFORM_DIRS": "1",
        "IPYTHONDIR": str(folder / "ipython"),
        "PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), path])),
    }
    before = dict(os.environ)
    os.environ.update(changed)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def execute(path: Path) -> nbformat.NotebookNode:
    """Return a notebook with its outputs, executed in an empty folder."""
    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as name:
        work = Path(name) / "work"
        work.mkdir()
        with _kernel(Path(name)):
            resources = {"metadata": {"path": str(work)}}
            NotebookClient(
                notebook,
                timeout=LONGEST,
                kernel_name=_KERNEL,
                resources=resources,
                coalesce_streams=True,
            ).execute()
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    for cell in notebook.cells:
        cell.metadata = {name: one for name, one in cell.metadata.items() if name == "mystnb"}
        if cell.cell_type == "code":
            cell.execution_count = None
            for output in cell.outputs:
                if "execution_count" in output:
                    output.execution_count = None
    return notebook


def main(names: Sequence[str]) -> None:
    """Store the outputs of notebooks, by default of all."""
    for path in NOTEBOOKS:
        if not names or path.stem in names:
            print(path.name, flush=True)
            nbformat.write(execute(path), path)


if __name__ == "__main__":
    main(sys.argv[1:])
