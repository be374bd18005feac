"""Coupled runs that go on where the same system was saved."""

import math

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Adaptive, Coupling, Link, Scaling
from tests.cosim.single import halves, joined, one, repacked

STEP, HALF, STOP = 0.01, 0.3, 0.8
COUPLINGS = [
    Coupling("jacobi", degree=1),
    Coupling("gauss_seidel", degree=2),
    Coupling("iterative"),
    Coupling("iterative", degree=2),
    Coupling("gauss_seidel", degree=2, adaptive=Adaptive(1e-6)),
    Coupling("iterative", degree=2, adaptive=Adaptive(1e-6)),
    Coupling("jacobi", every={"left": 3}),
    Coupling("gauss_seidel", every={"right": 4}),
]


@pytest.mark.parametrize("coupling", COUPLINGS, ids=str)
def test_bit_for_bit_with_every_coupling(two_masses, linear, tmp_path, version, coupling):
    """All signals are recorded with FMI 2.0, one with FMI 3.0."""
    record = None if version == 2 else ["left.y1"]
    system = two_masses.system(linear, version)
    if not coupling.every:
        system.add("loop", linear(version, "d11"), {"d11": 0.5, "cubic": -0.01, "f1": 1.0})
        # A nonlinear loop of its own, whose gain is below 1 for Jacobi, and a signal from outside.
        system.connect("loop.y1", "loop.u1")
        system.expose("x", "loop.u2")
    inputs = {"x": np.sin} if system.inputs else {}
    stop = 0.84 if coupling.every else STOP
    spec = {"step": STEP, "stop": stop, "coupling": coupling, "record": record}
    whole, rest = halves(system, tmp_path / "half.state", None, inputs, until=HALF, **spec)
    np.testing.assert_array_equal(rest.values, whole.values[-len(rest.time) :])
    assert rest.values.std() > 0


def test_rounding_left_by_derivatives_does_not_reach_the_solver(linear, version):
    """Bit for bit as with the same FMU that leaves nothing; an oscillation, so all of it counts."""
    results = []
    for flags in ((), ("-DLEAVES_ROUNDING",)):
        parameters = {"a12": 1.0, "a21": -1.0, "c11": 1.0, "x1": 1.0}
        system = one(linear(version, exchange=True, flags=flags), parameters)
        with system.prepare(step=0.01, stop=5.0) as simulation:
            results.append(simulation.run()["a.y1"])
    assert np.array_equal(*results)
    assert results[0][-1] == pytest.approx(math.cos(5.0), abs=1e-3)
    assert 1.0 + 1e-30 == 1.0


def ring(linear):
    """Two components of one state each, connected in a ring; one has an input from outside."""
    first = linear, {"a11": -1.0, "b11": 1.0, "b12": 1.0, "c11": 1.0, "x1": 1.0}
    parts = {"a": first, "b": (linear, {"a11": -2.0, "b11": 1.0, "c11": 1.0})}
    system = joined(parts, "b.y1 a.u1", x="a.u2")
    system.connect("a.y1", "b.u1", Link(Scaling(2.0, 0.5)))
    return system


def link(system, factor, offset):
    system.links["b.u1"] = Link(Scaling(factor, offset))


def reverse(system):
    system.components = dict(reversed(system.components.items()))


def other_file(system):
    """The same description and token, another binary."""
    old = system.components["b"].path
    new = repacked(
        old,
        old.with_name("other.fmu"),
        lambda name, content: content + b"\0" * ("binaries" in name),
    )
    system.components["b"] = cosim.Fmu(new)


CHANGES = [
    (lambda s: s.connections.pop("a.u1"), r"input a\.u1 was b\.y1, .*, is absent"),
    (lambda s: s.connect("a.y1", "b.u2"), r"input b\.u2 was absent, is a\.y1"),
    (lambda s: s.connections.update({"a.u1": "b.y2"}), r"input a\.u1 was b\.y1, .* is b\.y2"),
    (lambda s: link(s, 3.0, 0.5), r"input b\.u1 was .*factor=2\.0.* is .*factor=3\.0"),
    (lambda s: link(s, 2.0, 0.0), r"input b\.u1 was .*offset=0\.5.* is .*offset=0\.0"),
    (lambda s: s.inputs.pop("x"), r"input a\.u2 was x, .* is absent"),
    (lambda s: s.set("b.a11", -3.0), r"start value of b\.a11 was -2\.0, is -3\.0"),
    (lambda s: s.set("b.f1", 1.0), r"start value of b\.f1 was absent, is 1\.0"),
    (reverse, r"order of the components was a, b, is b, a"),
    (other_file, r"component b was co_simulation of the file with SHA-256"),
]


@pytest.mark.parametrize(
    ("change", "how", "said"),
    [
        *((change, {}, said) for change, said in CHANGES),
        (None, {"step": 0.05}, r"step was 0\.1, is 0\.05"),
        (None, {"start": 0.1}, r"start was 0\.0, is 0\.1"),
        (None, {"coupling": "jacobi"}, "coupling was .*gauss_seidel.* is .*jacobi"),
        (None, {"tolerance": 1e-3}, r"tolerance was None, is 0\.001"),
        (None, {"record": ["a.y1"]}, "signals was"),
    ],
)
def test_a_changed_system_is_refused_and_the_change_named(linear, tmp_path, change, how, said):
    fmu = tmp_path / "linear.fmu"
    fmu.write_bytes(linear(2).read_bytes())
    spec = {"step": 0.1, "stop": 1.0}
    system = ring(fmu)
    with system.prepare(**spec) as simulation:
        simulation.run(inputs={"x": np.sin}, until=0.5)
        path = simulation.save(tmp_path / "half.state")
    if change:
        change(system)
    with (
        system.prepare(**{**spec, **how}) as simulation,
        pytest.raises(cosim.SimulationError, match=said) as error,
    ):
        simulation.resume(path)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 1000


@pytest.mark.thorough
def test_what_changes_nothing_may_change(linear, tmp_path):
    """A later stop, names, outputs of the system, another way to step and to give parameters."""
    system = ring(linear(2))
    with system.prepare(step=0.1, stop=1.0) as simulation:
        whole = simulation.run({"b.a11": -3.0}, {"x": np.sin})
        simulation.run({"b.a11": -3.0}, {"x": np.sin}, until=0.5)
        path = simulation.save(tmp_path / "half.state")
    system.name = "renamed"
    system.expose_output("y", "a.y1")
    how = {"compiled": True, "allow_nan": True, "isolation": "process"}
    with system.prepare(step=0.1, stop=2.0, **how) as simulation:
        rest = simulation.resume(path, {"x": np.sin})
    np.testing.assert_array_equal(rest.values[:6], whole.values[5:])
    assert rest.time[-1] == 2.0
