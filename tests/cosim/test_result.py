"""What is shown: results as tables, files and plots, and the diagram of a system."""

import itertools
from io import StringIO
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot as plt

from stickslip import cosim
from stickslip.cosim import kernel
from stickslip.fmi.messages import scaled_unit
from tests.cosim.single import joined


@pytest.fixture
def result(make):
    system = joined({"a": make("integrator")}, force="a.u")
    with system.prepare(step=0.1, stop=1.0, record=["force", "a.y", "a.k"]) as simulation:
        return simulation.run(inputs={"force": lambda t: np.sin(t) / 3})


def test_names_units_and_frame(result):
    assert tuple(result) == result.names == ("force", "a.y", "a.k")
    assert result.units == {"force": "N", "a.y": "N", "a.k": None}
    frame = result.frame()
    assert frame.index.name == "time"
    assert frame.attrs["units"] == result.units
    np.testing.assert_array_equal(frame["a.y"], result["a.y"])


def test_csv_keeps_every_digit(result, tmp_path):
    read = pd.read_csv(result.to_csv(tmp_path / "out.csv"))
    assert list(read) == ["time", "force", "a.y", "a.k"]
    np.testing.assert_array_equal(read["time"], result.time)
    np.testing.assert_array_equal(read["a.y"], result["a.y"])
    for name, value in zip(result, (np.nan, -np.inf, -0.0), strict=True):
        result[name][0] = value
    text = result.to_csv(tmp_path / "out.csv").read_text()
    assert text == result.frame().to_csv(lineterminator="\n", na_rep="nan")


def test_numbers_are_written_as_python_writes_them():
    random = np.random.default_rng(0)
    powers = 2.0 ** np.arange(-1074, 1024)
    each = [
        random.integers(0, 2**64, 20_000, dtype=np.uint64).view(float),  # any double
        random.standard_normal(10_000).round(3),
        random.standard_normal(10_000) * 10.0 ** random.integers(-8, 20, 10_000),
        random.integers(-(10**17), 10**17, 10_000).astype(float),
        *(powers, np.nextafter(powers, 0.0), np.nextafter(powers, np.inf)),
        [float(f"1e{k}") for k in range(-323, 309)],
        [0.0, -0.0, np.nan, -np.nan, np.inf, -np.inf],
    ]
    numbers = np.concatenate(each)
    numbers = np.repeat(numbers, random.integers(1, 3, len(numbers)))
    lines = bytes(kernel.lines_of(numbers, -numbers[:, None])).decode().splitlines()
    assert lines == [f"{number!r},{-number!r}" for number in numbers.tolist()]
    two = np.array([0.5, 2.0]), np.array([[1.0, 3.0], [1e-5, 4.0]])
    assert kernel.lines_of(*two) == b"0.5,1.0,3.0\n2.0,1e-05,4.0\n"


def test_a_variable_that_one_component_has_needs_no_component(result, make):
    np.testing.assert_array_equal(result["y"], result["a.y"])
    assert "y" in result
    assert "x" not in result
    both = joined(dict.fromkeys("ab", make("integrator"))).prepare(step=0.1, stop=0.2).run()
    with pytest.raises(KeyError, match=r"'y' was recorded of several components: a\.y, b\.y"):
        both["y"]
    assert "y" not in both


@pytest.mark.parametrize(
    ("unit", "largest", "expected"),
    [
        ("m/s", 0.04, (1e3, "mm/s")),
        ("m", 1e-3 * (1 - 1e-12), (1e3, "mm")),
        ("m", 3e-6, (1e6, "µm")),
        ("N", 0.0, (1.0, "N")),
        ("N", float("inf"), (1.0, "N")),
        ("kg", 1e-3, (1.0, "kg")),
        ("min", 1e-3, (1.0, "min")),
        (None, 1e-3, (1.0, "1")),
    ],
)
def test_the_unit_of_a_plot_has_the_prefix_of_its_values(unit, largest, expected):
    factor, name = scaled_unit(unit, largest)
    assert (factor, name) == (pytest.approx(expected[0]), expected[1])


@pytest.fixture
def drawing():
    with mpl.rc_context({"backend": "agg"}):
        yield
        plt.close("all")


@pytest.mark.usefixtures("drawing")
def test_a_plot_has_a_panel_for_each_unit(result):
    forces, gain = result.plot()
    assert [line.get_label() for line in forces.lines] == ["force", "a.y"]
    assert forces.get_ylabel() == "[N]"
    assert gain.get_ylabel() == "a.k [1]"
    assert gain.get_xlabel() == "time [s]"
    np.testing.assert_allclose(forces.lines[1].get_ydata(), result["a.y"])
    (one,) = result.plot("y")
    assert one.get_ylabel() == "a.y [N]"
    assert one.get_legend() is None
    assert result.plot("force", axes=[one]) == result.plot("force", axes=one) == [one]
    assert len(one.lines) == 3
    with pytest.raises(KeyError, match=r"'a\.z' was not recorded; did you mean"):
        result.plot("a.z")
    with pytest.raises(ValueError, match="expected axes for 2 units, got 1"):
        result.plot(axes=[one])


def test_a_notebook_shows_tables(result, make):
    shown = result._repr_html_()
    assert "11 points, 0 to 1 s" in shown
    (row,) = pd.read_html(StringIO(shown))[0].query("signal == 'a.y'").to_dict("records")
    assert row["unit"] == "N"
    assert row["last"] == pytest.approx(result["a.y"][-1], rel=1e-5)
    assert repr(result) == "Result(11 points: force [N], a.y [N], a.k [])"
    system = cosim.System("loop")
    system.add("a", make("integrator"), {"k": 2.0})
    system.expose("<force>", "a.u")
    parts, wires = pd.read_html(StringIO(system._repr_html_()))
    assert parts["set"].tolist() == ["k = 2.0"]
    assert wires.to_numpy().tolist() == [["<force>", "a.u", "N"]]
    assert repr(system) == "System(loop: a)"


SVG = "{http://www.w3.org/2000/svg}"


def system(seed: int) -> cosim.System:
    """Return components in random circles and chains, with exposed inputs and outputs."""
    rng = np.random.default_rng(seed)
    names = [f"part{k}" for k in range(rng.integers(1, 9))]
    made = cosim.System(f"s{seed}")
    for name in names:
        inputs, outputs = ({f"{way}{k}": None for k in range(3)} for way in ("in", "out"))
        made.add(name, cosim.Function(lambda t, u: dict.fromkeys(outputs, t), inputs, outputs))  # noqa: ARG005, B023
    for name, k in itertools.product(names, range(3)):
        if rng.random() < 0.5:
            made.connect(f"{rng.choice(names)}.out{rng.integers(3)}", f"{name}.in{k}")
        elif rng.random() < 0.5:
            made.expose(f"<{name}&{k}>", f"{name}.in{k}")
    made.expose_output("last", f"{names[-1]}.out0")
    return made


@pytest.mark.parametrize("seed", range(6))
def test_every_box_and_wire_is_drawn_and_boxes_are_apart(seed):
    made = system(seed)
    drawing = ET.fromstring(made.diagram())  # noqa: S314 - our own
    titles = {one.text for one in drawing.iter(f"{SVG}title")}
    wires = {f"{source} to {target}" for target, source in made.connections.items()}
    wires |= {f"{name} to {one}" for name, targets in made.inputs.items() for one in targets}
    wires |= {f"{source} to {name}" for name, source in made.outputs.items()}
    assert titles == wires
    boxes = [
        {key: float(box.get(key)) for key in ("x", "y", "width", "height")}
        for box in drawing.iter(f"{SVG}rect")
    ]
    assert len(boxes) == len(made.components) + len(made.inputs) + len(made.outputs)
    for one, other in itertools.combinations(boxes, 2):
        beside = one["x"] + one["width"] <= other["x"] or other["x"] + other["width"] <= one["x"]
        above = one["y"] + one["height"] <= other["y"] or other["y"] + other["height"] <= one["y"]
        assert beside or above
    _, _, width, height = (float(x) for x in drawing.get("viewBox").split())
    assert all(b["x"] + b["width"] <= width and b["y"] + b["height"] <= height for b in boxes)
    assert made.diagram() in made._repr_html_()
