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

OTHERS = {
    "control",
    "ctypes",
    "fmpy",
    "matplotlib",
    "numpy",
    "pandas",
    "pathlib",
    "subprocess",
    "sys",
}
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
        assert not cell.metadata
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


def test_loop_design():
    text = printed("loop_design")

    def at(pattern: str) -> float:
        return number(pattern, text)

    assert at("crossover +# Hz") == pytest.approx(125.0)
    assert at("phase margin +# deg") == pytest.approx(50.0)
    assert at("FMU and python-control: # m/s") < 1e-9
    assert at("= # % of the step") < 0.01
    without, with_compensation = (
        at(rf"{label} compensation +largest difference from the prediction # mm/s")
        for label in ("without", "with")
    )
    assert with_compensation < 0.1 * without
    without, with_compensation = (
        at(rf"{label} compensation +error # mm/s at most") for label in ("without", "with")
    )
    assert with_compensation < 0.2 * without
    assert at("nothing quantised error # µm/s at most") < 10.0
    assert at("without friction +differs from the design by # % at most") < 0.01
    assert at("with friction, 2 mm/s +differs from the design by # % at most") > 30.0
    assert at("linear axis and python-control: # m/s") < 1e-12
    assert at(r"at rest expected -#, .* found") == pytest.approx(
        at(r"at rest expected .* found -#, "), rel=1e-3
    )
    assert at(r"sliding expected .* found -[\d.]+, -#, ") == pytest.approx(1.19)


def test_laws():
    """Laws agree with closed forms, and show what the literature says of them."""
    text = printed("laws")
    for law in ("coulomb_stribeck", "gms"):
        assert number(rf"{law} +differs from the curve .* by # N", text) < 0.01
    for law in ("lugre", "leuven", "elasto_plastic"):
        assert number(rf"{law} +differs from the curve .* by # N", text) < 0.05
    assert number("gms +the minor loop stays open by # N", text) < 0.01
    assert number("lugre +the minor loop stays open by # N", text) > 0.2
    assert number(r"dahl +slides: # to", text) == pytest.approx(6.0, abs=0.02)
    assert text.count("sticks and slips") == 6


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


def test_sweep_and_optimise():
    text = printed("sweep_and_optimise")
    assert number("cost # after", text) < 0.8 * number("runs, # at the start", text)
    assert number("found +peak sensitivity #", text) < 2.2


def test_frequency_response():
    text = printed("frequency_response")
    expected = (3.9162e5 / 5.557) ** 0.5 / (2 * 3.14159265)
    assert number("resonance at # Hz", text) == pytest.approx(expected, rel=2e-3)
    assert number(r"0.01 N +differs from the linear system by # %", text) < 2.0
    assert number(r"\n2 N +differs from the linear system by # %", text) > 30.0


def test_export_and_run_elsewhere():
    text = printed("export_and_run_elsewhere")
    assert text.count("the same force bit for bit: True") == 2
    assert "no findings" in text
    assert "FUNCTION_BLOCK Compensator" in text


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


def test_arena():
    """Feedforward with an observer beats the tuned controller; alone it does harm carried over."""
    text = printed("arena")
    assert row("lugre+ekbf", text)[0] < 0.8
    assert row("lugre", text)[3] > 2.0
    assert len(row("mine", text)) == 4
