"""A file of a saved state is what was saved, or is refused."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.run.checkpoint import Checkpoint
from tests.corpus.defects import reference
from tests.cosim.single import repacked


@pytest.fixture
def halted(tmp_path):
    """A simulation halted at half its time, and the file of its state."""
    system = cosim.System("one")
    system.add("a", reference.pack(tmp_path / "a.fmu", reference.members(3)))
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
        ("format", "of format 1, this version of cosim reads 2; run again"),
    ],
)
def test_a_part_that_is_missing_is_told(halted, left_out, said):
    simulation, path = halted
    repacked(path, path, lambda name, content: None if name == f"{left_out}.npy" else content)
    with pytest.raises(cosim.SimulationError, match=said):
        simulation.resume(path)
    assert len(simulation.run().time) == 11


def test_a_row_of_another_length_is_told(halted):
    simulation, path = halted
    row = b"\x93NUMPY\1\0v\0{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }\n"
    repacked(path, path, lambda name, content: row + bytes(8) if name == "row.npy" else content)
    with pytest.raises(cosim.SimulationError, match="damaged"):
        simulation.resume(path)


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
    system = cosim.System("one")
    system.add("a", reference.pack(tmp_path / "a.fmu", reference.members(3)))
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
