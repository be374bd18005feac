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
LONG = ("arena", "learn_from_a_log")
"""They take half of the time of all."""


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


def printed(name: str) -> str:
    """Return the stored text of a notebook."""
    return "\n".join(text for cell in texts(stored(name)) for text in cell)


def number(pattern: str, text: str) -> float:
    """Return the number at # of a pattern in a text."""
    match = re.search(pattern.replace("#", r"([\d.]+(?:e[-+]?\d+)?)"), text)
    assert match, f"no {pattern!r} in:\n{text}"
    return float(match[1])


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


@pytest.mark.parametrize("name", [*sorted(NAMES.keys() - {*LONG}), *further(*LONG)])
def test_gives_what_is_stored(name):
    """Text is the same, and numbers agree; pictures are as many."""
    now, then, within = execute(NAMES[name]), stored(name), WITHIN.get(name, 0.02)
    assert pictures(now) == pictures(then)
    for new, old in zip(texts(now), texts(then), strict=True):
        assert [NUMBER.sub("#", text) for text in new] == [NUMBER.sub("#", text) for text in old]
        for here, there in zip(new, old, strict=True):
            numbers = [[float(one) for one in NUMBER.findall(text)] for text in (here, there)]
            assert numbers[0] == pytest.approx(numbers[1], rel=within, abs=1e-9)


FACTS = [  # what a notebook shows is within bounds that theory or the literature gives
    ("loop_design", "crossover +# Hz", 125.0, 1e-6),
    ("loop_design", "phase margin +# deg", 50.0, 1e-6),
    ("loop_design", "FMU and python-control: # m/s", 0.0, 1e-9),
    ("loop_design", "= # % of the step", 0.0, 0.01),
    ("loop_design", "nothing quantised error # µm/s at most", 0.0, 10.0),
    ("loop_design", "without friction +differs from the design by # % at most", 0.0, 0.01),
    ("loop_design", "with friction, 2 mm/s +differs from the design by # % at most", 65.0, 35.0),
    ("loop_design", "linear axis and python-control: # m/s", 0.0, 1e-12),
    ("loop_design", r"sliding expected .* found -[\d.]+, -#, ", 1.19, 1e-6),
    ("laws", "coulomb_stribeck +differs from the curve .* by # N", 0.0, 0.01),
    ("laws", "gms +differs from the curve .* by # N", 0.0, 0.01),
    ("laws", "lugre +differs from the curve .* by # N", 0.0, 0.05),
    ("laws", "leuven +differs from the curve .* by # N", 0.0, 0.05),
    ("laws", "elasto_plastic +differs from the curve .* by # N", 0.0, 0.05),
    ("laws", "gms +the minor loop stays open by # N", 0.0, 0.01),
    ("laws", "lugre +the minor loop stays open by # N", 0.6, 0.4),
    ("laws", r"dahl +slides: # to", 6.0, 0.02),
    ("sweep_and_optimise", "found +peak sensitivity #", 1.6, 0.6),
    ("frequency_response", "resonance at # Hz", (3.9162e5 / 5.557) ** 0.5 / 6.2831853, 0.09),
    ("frequency_response", r"0.01 N +differs from the linear system by # %", 0.0, 2.0),
    ("frequency_response", r"\n2 N +differs from the linear system by # %", 65.0, 35.0),
]


@pytest.mark.parametrize(("name", "pattern", "expected", "within"), FACTS)
def test_shows_what_is_so(name, pattern, expected, within):
    assert number(pattern, printed(name)) == pytest.approx(expected, abs=within)


@pytest.mark.parametrize(
    ("name", "text", "times"),
    [
        ("laws", "sticks and slips", 6),
        ("export_and_run_elsewhere", "the same force bit for bit: True", 2),
        ("export_and_run_elsewhere", "no findings", 1),
        ("export_and_run_elsewhere", "FUNCTION_BLOCK Compensator", 1),
    ],
)
def test_says_what_is_so(name, text, times):
    assert printed(name).count(text) == times


def row(name: str, text: str) -> list[float]:
    """Return the numbers of the first line that begins with a name."""
    line = next(line for line in text.splitlines() if re.match(rf"{re.escape(name)}  ", line))
    return [float(word) for word in NUMBER.findall(line.removeprefix(name))]


def test_compensators():
    """Exact feedforward leaves least, is as bad as none at half the friction, and keeps Ms."""
    text = printed("compensators")
    names = ("none", "static", "LuGre", "observer", "LuGre + observer")
    exact, half = ({name: row(name, text)[k] for name in names} for k in (0, 1))
    assert exact["LuGre"] < 0.1 * exact["none"]
    assert exact["LuGre"] < exact["static"] < exact["observer"] < 0.3 * exact["none"]
    assert half["LuGre"] > 0.9 * half["none"]
    assert max(half["observer"], half["LuGre + observer"]) < 0.3 * half["none"]


def test_learn_from_a_log():
    """What was learned is near the truth, and the spoilt log is refused."""
    text = printed("learn_from_a_log")
    values = {"F_s": 8.999, "F_c": 5.999, "sigma_0": 3.9162e5, "sigma_1": 4424.8, "m": 5.557}
    for name, value in values.items():
        assert number(rf"{name} = #[,)]", text) == pytest.approx(value, rel=0.03)
    assert "to be written: no compensation" in text
    assert "out of scale" in text
    tables = [
        output.data["text/html"]
        for cell in code_cells(stored("learn_from_a_log"))
        for output in cell.outputs
        if "text/html" in output.get("data", {})
    ]
    assert "written: feedforward + observer" in tables[0]
    assert "compensator not written: the logged force is out of scale" in tables[-1]
