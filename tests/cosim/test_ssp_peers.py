"""Our packages in FMPy, libcosim and pyssp_standard.

What they leave out is given to them by hand: FMPy reads no parameter bindings, and its first step
sees zeros at all inputs; libcosim reads no nested systems and no inputs of the system itself. So
all outputs begin at 0, and integrators whose inputs have start values move the system.
"""

import string
from types import SimpleNamespace

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

from stickslip import cosim
from stickslip.cosim.system.scaling import Link, Scaling

pytestmark = pytest.mark.slow

STEP = 0.25
EXPERIMENT = cosim.DefaultExperiment(start=0.0, stop=2.0, step=STEP)


def drawn(make, seed, *, nested=False, scaled=False, fmi=2):
    """Return a system of gains and integrators, in loops or not, that begins at rest."""
    rng = np.random.default_rng(seed)
    system = cosim.System(f"drawn{seed}")
    names = list(string.ascii_lowercase[: rng.integers(3, 9)])
    names = [f"n/{x}" if nested and rng.random() < 0.5 else x for x in names]
    kinds = ["integrator", *rng.choice(["gain", "integrator"], len(names) - 1)]
    for name, kind in zip(names, kinds, strict=True):
        units = {"y": "mN"} if scaled and rng.random() < 0.3 else {}
        k = 0.0 if kind == "integrator" else rng.uniform(-1.5, 1.5)
        system.add(name, make(kind, fmi, **units), {"k": k})
    system.set(f"{names[0]}.u", rng.uniform(1, 2))
    for name, kind in zip(names[1:], kinds[1:], strict=True):
        if kind == "integrator" and rng.random() < 0.2:
            system.set(f"{name}.u", rng.uniform(-1, 1))
            continue
        factor = rng.uniform(0.1, 2.0) if scaled and rng.random() < 0.5 else 1.0
        system.connect(f"{rng.choice(names)}.y", f"{name}.u", Link(Scaling(factor)))
    return system


def jacobi(system):
    return system.prepare(step=STEP, stop=EXPERIMENT.stop, coupling="jacobi").run()


def in_fmpy(system, path, **inputs):
    """Return the last value of each signal of a package run by FMPy."""
    given = [
        SimpleNamespace(name=name.replace("/", "."), value=value)
        for name, value in system.parameters.items()
    ]
    result = simulate_ssp(
        str(path),
        stop_time=EXPERIMENT.stop - 0.5 * STEP,  # it adds steps up, and may do one more
        step_size=STEP,
        parameter_set=SimpleNamespace(parameters=given),
        input={name: lambda _, value=value: value for name, value in inputs.items()},
    )
    return result[-1]


def in_libcosim(system, path, signals):
    """Return the last values of signals of a package run by libcosim; the step is in the file."""
    execution = CosimExecution.from_ssp_file(str(path))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    execution.simulate_until(round(EXPERIMENT.stop * 1e9))
    values = {}
    for signal in signals:
        component, _ = signal.split(".")
        slave = execution.slave_index_from_instance_name(component)
        (values[signal],) = observer.last_real_values(slave, [system.variable(signal).reference])
    return values


SEEDS = range(8)


@pytest.mark.parametrize("seed", SEEDS)
def test_libcosim_runs_any_system_to_the_values_of_our_jacobi(make, tmp_path, seed):
    system = drawn(make, seed, scaled=True)
    path = cosim.write_ssp(system, tmp_path / "a.ssp", EXPERIMENT)
    ours = jacobi(system)
    theirs = in_libcosim(system, path, [name for name in ours if name.endswith(".y")])
    assert theirs == {name: pytest.approx(ours[name][-1], rel=1e-12, abs=1e-13) for name in theirs}
    assert any(theirs.values())


@pytest.mark.parametrize("seed", SEEDS)
def test_fmpy_runs_any_system_to_the_values_of_our_jacobi(make, tmp_path, seed):
    system = drawn(make, seed, nested=True)
    path = cosim.write_ssp(system, tmp_path / "a.ssp", EXPERIMENT)
    theirs, ours = in_fmpy(system, path), jacobi(system)
    shown = [name for name in ours if name.endswith(".y")]
    assert {name: theirs[name.replace("/", ".")] for name in shown} == {
        name: ours[name][-1] for name in shown
    }


def test_fmpy_takes_inputs_of_the_system(make, tmp_path):
    system = cosim.System("one")
    system.add("gain", make("gain"), {"k": 3.0})
    system.expose("x", "gain.u")
    system.expose_output("y", "gain.y")
    path = cosim.write_ssp(system, tmp_path / "a.ssp", EXPERIMENT)
    theirs = in_fmpy(system, path, x=2.0)
    assert (theirs["gain.y"], theirs["y"]) == (6.0, 6.0)


def test_the_same_system_gives_the_same_bytes(make, tmp_path):
    system = drawn(make, 1, nested=True, scaled=True)
    one, again = (cosim.write_ssp(system, tmp_path / f"{n}.ssp", EXPERIMENT) for n in "ab")
    assert one.read_bytes() == again.read_bytes()
    read, experiment = cosim.read_ssp(one)
    assert experiment == EXPERIMENT
    assert cosim.write_ssp(read, again, experiment).read_bytes() == one.read_bytes()
