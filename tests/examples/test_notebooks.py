"""Every notebook is stored with its outputs, uses public names only, and runs as stored."""

import ast
import re
from functools import cache

import nbformat
import pytest

import stickslip as ss
from tests.kept import further
from tests.stored_notebooks import NOTEBOOKS, execute

# Jupyter's own, on some of its versions and systems: old calls into asyncio and zmq.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::DeprecationWarning:jupyter_client"),
    pytest.mark.filterwarnings("ignore::RuntimeWarning:zmq"),
]

OTHERS = {*("control", "ctypes", "fmpy", "matplotlib", "numpy", "pandas")}
OTHERS |= {*("pathlib", "subprocess", "sys")}
"""What notebooks import beside stickslip."""
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")
WITHIN = {"arena": 0.3}
"""Relative differences of numbers; 0.02 where not given. A short search depends on rounding."""
NAMES = {path.stem: path for path in NOTEBOOKS}
LONG = {*("arena", "compensators", "export_and_run_elsewhere", "frequency_response", "laws")}
LONG |= {*("learn_from_a_log", "loop_design", "phenomena", "sweep_and_optimise")}
"""They take most of the time of all, for calls that other tests and pages make as well."""


def code_cells(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def texts(notebook: nbformat.NotebookNode) -> list[list[str]]:
    """Return what each cell printed and showed as text."""
    found = []
    for cell in code_cells(notebook):
        shown = ["".join(o.get("text", "")) for o in cell.outputs if o.output_type == "stream"]
        shown += [o.data.get("text/plain", "") for o in cell.outputs if "data" in o]
        found.append(shown)
    return found


def pictures(notebook: nbformat.NotebookNode) -> list[int]:
    """Return how many pictures each cell shows."""
    return [
        sum("image/png" in output.get("data", {}) for output in cell.outputs)
        for cell in code_cells(notebook)
    ]


@cache
def stored(name: str) -> nbformat.NotebookNode:
    return nbformat.read(NAMES[name], as_version=4)


@pytest.mark.parametrize("name", NAMES)
def test_is_stored_with_outputs_and_without_traces_of_a_machine(name):
    notebook = stored(name)
    nbformat.validate(notebook)
    assert set(notebook.metadata) <= {"kernelspec", "language_info"}
    for cell in code_cells(notebook):
        assert cell.execution_count is None
        assert {*cell.metadata} <= {"mystnb"}
        assert not [
            o for o in cell.outputs if o.output_type == "error" or o.get("name") == "stderr"
        ]
    assert sum(pictures(notebook)) >= 1
    assert not re.search(r"/(home|work|tmp|root|usr|Users)/|[A-Z]:\\", nbformat.writes(notebook))


@pytest.mark.parametrize("name", NAMES)
def test_uses_public_names_only(name):
    for cell in code_cells(stored(name)):
        tree = ast.parse(re.sub(r"(?m)^%.*", "", cell.source))
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                for one in node.names:
                    assert one.name.partition(".")[0] in OTHERS or one.name == "stickslip"
            elif isinstance(node, ast.ImportFrom):
                assert node.module.partition(".")[0] in OTHERS
            elif isinstance(node, ast.Attribute):
                if isinstance(node.value, ast.Name) and node.value.id == "ss":
                    assert node.attr in ss.__all__
                assert not node.attr.startswith("_")


@pytest.mark.parametrize("name", [*sorted(NAMES.keys() - LONG), *further(*sorted(LONG))])
def test_gives_what_is_stored(name):
    """Text is the same, and numbers agree; pictures are as many."""
    now, then, within = execute(NAMES[name]), stored(name), WITHIN.get(name, 0.02)
    assert pictures(now) == pictures(then)
    for new, old in zip(texts(now), texts(then), strict=True):
        assert [NUMBER.sub("#", text) for text in new] == [NUMBER.sub("#", text) for text in old]
        for here, there in zip(new, old, strict=True):
            numbers = [[float(one) for one in NUMBER.findall(text)] for text in (here, there)]
            assert numbers[0] == pytest.approx(numbers[1], rel=within, abs=1e-9)
