"""Runs by steps, and files of their saved states."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.run.checkpoint import Checkpoint
from tests.corpus.defects import reference
from tests.cosim.single import joined, one, repacked

STEP, N = 0.01, 40
STOP = N * STEP


@pytest.fixture
def system(make):
    """Return a ring of a gain and two integrators of both versions, with one input."""
    parts = {"gain": (make("gain", 2), {"k": -2.0})}
    parts |= {"speed": make("integrator", 3), "place": make("integrator", 2)}
    return joined(parts, "speed.y place.u", "place.y gain.u", name="ring", u="speed.u")


def courses():
    """Return an input that changes at some points in time."""
    return np.repeat(np.sin(np.arange(N // 4 + 1)), 4)[: N + 1]


def by_steps(simulation, u, parameters=None):
    """Return the rows of a run by steps."""
    rows = [simulation.start(parameters, {"u": u[0]})]
    return rows + [simulation.step({"u": x}) for x in u[:-1]]


HOW = {
    "plain": {},
    "jacobi": {"coupling": "jacobi"},
    "some": {"record": cosim.Record(["place.y", "u"])},
    "last": {"record": cosim.Record(keep="last")},
    "compiled": {"compiled": True, "constant_step": True},
    "line": {"coupling": cosim.Coupling(degree=1)},
    "parabola": {"coupling": cosim.Coupling("jacobi", degree=2)},
    "rates": {"coupling": cosim.Coupling(every={"place": 4})},
    "apart": {"isolation": "process"},
}


@pytest.mark.parametrize("how", HOW)
def test_steps_are_the_whole_run(system, how):
    u = courses()
    held = cosim.Table(STEP * np.arange(N + 1), u, held=True)
    more = {k: v for k, v in HOW[how].items() if k != "record"}
    with system.prepare(step=STEP, stop=STOP, **more) as simulation:
        whole = simulation.run({"gain.k": 3.0}, {"u": held})
    with system.prepare(step=STEP, stop=STOP, **HOW[how]) as simulation:
        rows = by_steps(simulation, u, {"gain.k": 3.0})
        assert by_steps(simulation, u, {"gain.k": 3.0}) == rows
        assert simulation.run({"gain.k": 3.0}, {"u": held})["place.y"][-1] == rows[-1]["place.y"]
    assert "u" not in rows[0]
    for name in rows[0]:
        assert [row[name] for row in rows] == whole[name].tolist(), name
    assert len(set(whole["place.y"])) > N // 8


def test_an_input_that_is_not_given_holds_and_no_point_needs_memory(system):
    last = cosim.Record(keep="last")
    with system.prepare(step=STEP, stop=1e7, record=last) as simulation:
        simulation.start(inputs={"u": 2.0})
        for k in range(1, N):
            assert simulation.step()["speed.y"] == pytest.approx(1.0 + 2.0 * k * STEP)


def test_a_halt_of_a_run_by_steps_has_values(system):
    with system.prepare(step=STEP, stop=STOP) as simulation:
        simulation.start({"gain.k": 5.0})
        outputs = simulation.step({"u": 1.0})
        assert simulation.values(["gain.k", "speed.y"]) == [5.0, outputs["speed.y"]]


@pytest.mark.parametrize("isolation", [None, "process"])
def test_what_is_wrong_is_said(system, isolation):
    with system.prepare(step=STEP, stop=2 * STEP, isolation=isolation) as simulation:
        with pytest.raises(cosim.SimulationError, match=r"ring: .* begin one with start\(\)"):
            simulation.step()
        simulation.start()
        with pytest.raises(cosim.SignalError, match="no exposed input 'v'"):
            simulation.step({"v": 1.0})
        with pytest.raises(cosim.SignalError, match="not finite at t = 0 s"):
            simulation.step({"u": float("nan")})
        assert simulation.step({"u": 1.0})["speed.y"] == pytest.approx(1.0 + STEP)
        simulation.step()
        with pytest.raises(cosim.ExperimentError, match=r"at its stop, 0\.02 s"):
            simulation.step()
        simulation.run()
        with pytest.raises(cosim.SimulationError, match="expected a run by steps"):
            simulation.step()
        simulation.start({"gain.fault": 3, "gain.fault_time": STEP})
        simulation.step()
        with pytest.raises(cosim.SimulationError, match="gain: fmi2"):
            simulation.step()
        with pytest.raises(cosim.SimulationError, match="expected a run by steps"):
            simulation.step()
        simulation.start()
        simulation.close()
        with pytest.raises(cosim.SimulationError, match="expected a run by steps"):
            simulation.step()


@pytest.fixture
def simulation(make):
    system = one(make("integrator"), u="u")
    with system.prepare(step=0.001, stop=0.1) as simulation:
        yield simulation


def test_a_halt_lies_on_a_point_in_time_and_needs_fmus_that_serialise(simulation, tmp_path):
    with pytest.raises(cosim.ExperimentError, match="not a point in time"):
        simulation.run(until=0.0505)
    half = simulation.run(until=0.05)
    assert half.time[-1] == simulation.time[50]
    with pytest.raises(cosim.SimulationError, match=r"a cannot serialise it"):
        simulation.save(tmp_path / "a.state")
    whole = simulation.run()
    np.testing.assert_array_equal(whole.values[:51], half.values)


@pytest.fixture
def halted(tmp_path):
    """A simulation halted at half its time, and the file of its state."""
    system = one(reference.pack(tmp_path / "a.fmu", reference.members(3)))
    with system.prepare(step=0.1, stop=1.0) as simulation:
        simulation.run(until=0.5)
        yield simulation, simulation.save(tmp_path / "half.state")


def test_it_comes_back_bit_for_bit(tmp_path):
    # of all kinds that the general path and couplings keep
    kinds = {f"/{kind}": np.ones(3, kind) for kind in ("f8", "f4", "i4", "i8", "u1", "u8", "b1")}
    saved = Checkpoint({"step": "id \xe4"}, 7, np.arange(2.0), {"a": b"\0\1"}, {"a.k": 1.5}, kinds)
    again = Checkpoint.read(saved.write(tmp_path / "state"))
    assert (again.identity, again.step, again.states) == (saved.identity, 7, saved.states)
    assert again.starts == saved.starts
    for name, values in kinds.items():
        assert again.memory[name].dtype == values.dtype
        np.testing.assert_array_equal(again.memory[name], values)


@pytest.mark.parametrize(
    ("left_out", "said"),
    [
        ("row", "no saved state"),
        ("state:a", "damaged"),
        ("identity", "no saved state"),
        ("format", "of format 1, this version of cosim reads 4; run again"),
        ("", "damaged"),  # a row of another length
    ],
)
def test_a_part_that_is_missing_is_told(halted, left_out, said):
    simulation, path = halted
    row = b"\x93NUMPY\1\0v\0{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }\n"

    def change(name, content):
        short = row + bytes(8) if name == "row.npy" and not left_out else content
        return None if name == f"{left_out}.npy" else short

    repacked(path, path, change)
    with pytest.raises(cosim.SimulationError, match=said):
        simulation.resume(path)
    assert len(simulation.run().time) == 11


@pytest.mark.parametrize(
    ("part", "values"),
    [
        ("counts", [9e9, 0, 0, 0, 0.1]),
        ("counts", [1, 0, 0, 0, np.nan]),
        ("counts", [1.0]),
        ("known", [1] * 1000),
        ("past", [0.0]),
    ],
)
def test_what_a_coupling_remembers_is_its_own(tmp_path, part, values):
    """The kernel counts with these numbers."""
    system = one(reference.pack(tmp_path / "a.fmu", reference.members(3)))
    coupling = cosim.Coupling("iterative", adaptive=cosim.Adaptive(1e-3))
    with system.prepare(step=0.1, stop=1.0, coupling=coupling) as simulation:
        simulation.run(until=0.5)
        path = simulation.save(tmp_path / "half.state")
        saved = Checkpoint.read(path)
        replace(saved, memory={**saved.memory, f"/{part}": np.array(values)}).write(path)
        with pytest.raises(cosim.SimulationError, match="damaged"):
            simulation.resume(path)
        saved.write(path)
        assert len(simulation.resume(path).time) == 6
