"""FMI 1.0, against FMPy."""

from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import control
from tests.corpus import fmu
from tests.cosim.single import by_fmpy, exposed, one

VARIABLE = '<ScalarVariable name="{}" valueReference="{}" causality="{}" variability="{}" {}>{}'
ROWS = [
    ("u", 0, "input", "continuous", "", '<Real start="0"/>'),
    ("on", 4, "input", "discrete", "", '<Boolean start="true"/>'),
    ("k", 1, "internal", "parameter", "", '<Real start="1"/>'),
    ("x", 2, "internal", "continuous", "", "<Real/>"),
    ("minus_x", 2, "internal", "continuous", 'alias="negatedAlias"', "<Real/>"),
    ("y", 3, "output", "continuous", "", "<Real/><DirectDependency><Name>u</Name>"),
    ("high", 5, "output", "discrete", "", "<Boolean/><DirectDependency>"),
]
TIME = np.linspace(0.0, 1.0, 11)
U, ON = 1.0 + np.sin(7 * TIME), TIME < 0.45
SLAVE = "<Implementation><CoSimulation_StandAlone><Capabilities/></CoSimulation_StandAlone>"


def described(rows=ROWS, implementation=f"{SLAVE}</Implementation>"):
    """Return a description of FMI 1.0."""
    variables = "".join(
        VARIABLE.format(*row)
        + ("</DirectDependency>" if "<Direct" in row[-1] else "")
        + "</ScalarVariable>"
        for row in rows
    )
    return (
        '<fmiModelDescription fmiVersion="1.0" modelName="old" modelIdentifier="old" guid="{1}"'
        ' numberOfContinuousStates="1" numberOfEventIndicators="1">'
        f"<ModelVariables>{variables}</ModelVariables>{implementation}</fmiModelDescription>"
    )


@pytest.fixture(scope="module")
def binary():
    """Return path in the FMU -> library."""
    source = Path(__file__).with_name("fmi1.c")
    library = fmu.library("old", source, versions=(1,), complete=False)
    return {fmu.place("old", 2): library.read_bytes()}


def test_runs_equal_fmpy(tmp_path, binary):
    new = described().replace('modelName="old"', f'modelName="{uuid4()}"')  # to no cache
    path = fmu.pack(tmp_path / "old.fmu", new, binary)
    system = exposed(path, {"k": 0.5})
    how = {"inputs": [TIME, ("u", "f8", U), ("on", "?", ON)], "start_values": {"k": 0.5}}
    theirs = by_fmpy(path, 0.1, 1.0, "y", "high", **how)
    for isolation in ("process", None):
        with system.prepare(step=0.1, stop=1.0, isolation=isolation) as simulation:
            for _ in range(2):
                ours = simulation.run(inputs={"u": U, "on": ON})
                np.testing.assert_array_equal(ours["a.y"], theirs["y"])
                np.testing.assert_array_equal(ours["a.high"], theirs["high"])
    assert ours["a.y"][0] == 0.5 * U[0]
    assert 0 < ours["a.high"].sum() < len(TIME)
    assert system.components["a"].feedthrough == {"y": {"u"}, "high": set()}


def test_model_exchange_has_events_of_time_state_and_inputs(tmp_path, binary):
    path = fmu.pack(tmp_path / "exchange.fmu", described(implementation=""), binary)
    x = np.cumsum([0.0, *(0.05 * (U[1:] + U[:-1]) * ON[:-1])]) + (TIME >= 0.25)
    system, record = exposed(path, {"k": 0.5}), ["a.x", "a.y", "a.high"]
    with system.prepare(step=0.1, stop=1.0, record=record) as simulation:
        for _ in range(2):
            ours = simulation.run(inputs={"u": cosim.Table(TIME, U), "on": ON})
            np.testing.assert_allclose(ours["a.x"], x, atol=1e-4)
            np.testing.assert_allclose(ours["a.y"], x + 0.5 * U, atol=1e-4)
            np.testing.assert_array_equal(ours["a.high"], ours["a.y"] >= 1.0)
    assert 0 < ours["a.high"].sum() < len(TIME)


def test_what_is_not_run_is_one_line(tmp_path, binary):
    exchange = cosim.Fmu(fmu.pack(tmp_path / "me.fmu", described(implementation=""), binary))
    with pytest.raises(control.LinearisationError, match=r"me.fmu: FMI 1.0 does not name states"):
        control.linearise(exchange, isolation=None)
    negated = [("y", 3, "output", "continuous", 'alias="negatedAlias"', "<Real/>")]
    with pytest.raises(cosim.FmuError, match="output 'y' is a negated alias"):
        cosim.Fmu(fmu.pack(tmp_path / "negated.fmu", described(negated), binary))
    lacking = (*ROWS[-1][:-1], "<Boolean/><DirectDependency><Name>z</Name>")
    unclear = cosim.Fmu(fmu.pack(tmp_path / "lacking.fmu", described([lacking]), binary))
    assert "dependencies of Unknown" in unclear.description.remarks[0]
    system = one(fmu.pack(tmp_path / "old.fmu", described(), binary))
    with pytest.raises(
        cosim.FmuError, match=r"a \(old.fmu\) cannot go into a container: it is of FMI 1"
    ):
        cosim.write_fmu(system, tmp_path / "out.fmu", step=0.1)
