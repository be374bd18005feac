"""The paper's loop as a package, run by other tools."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from fmpy.ssp.simulation import simulate_ssp
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.servo.axis import Axis
from stickslip.servo.systems import build_fmus, paper_loop
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop

EXPERIMENT = cosim.DefaultExperiment(0.0, 0.5, 5e-4)
SIGNALS = ("nominal.v_r", "compensator.F_mean", "controller.u", "drive.x_enc", "drive.v")


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """Fig. 2a; the command is the start value of its targets, so that no tool must feed it."""
    folder = tmp_path_factory.mktemp("fmus")
    build_fmus(folder, {})
    loop = design_velocity_loop(Axis(PAPER["m"], PAPER["b"]), LoopSpecification(60.0, 60.0))
    system = paper_loop(folder, loop, {name: PAPER[name] for name in LUGRE})
    for target in system.inputs.pop("v_cmd"):
        system.set(target, 0.02)
    return system


@pytest.fixture(scope="module")
def package(system, tmp_path_factory):
    return cosim.write_ssp(system, tmp_path_factory.mktemp("ssp") / "loop.ssp", EXPERIMENT)


@pytest.fixture(scope="module")
def ours(system):
    with system.prepare(step=EXPERIMENT.step, stop=EXPERIMENT.stop, coupling="jacobi") as run:
        result = run.run()
    return {name: result[name][-1] for name in SIGNALS}


def test_the_loop_moves(ours):
    assert ours["drive.v"] == pytest.approx(0.02, rel=0.05)


def test_libcosim_runs_the_loop_to_the_values_of_our_jacobi(system, package, ours):
    execution = CosimExecution.from_ssp_file(str(package))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    execution.simulate_until(round(EXPERIMENT.stop * 1e9))
    for name in SIGNALS:
        slave = execution.slave_index_from_instance_name(name.partition(".")[0])
        (value,) = observer.last_real_values(slave, [system.variable(name).reference])
        assert value == pytest.approx(ours[name], rel=1e-9), name


def test_fmpy_runs_the_loop_to_the_values_of_our_jacobi(system, package, ours):
    """FMPy passes over the bindings, so it is given their values."""
    given = [SimpleNamespace(name=name, value=x) for name, x in system.parameters.items()]
    result = simulate_ssp(
        str(package),
        stop_time=EXPERIMENT.stop - 0.5 * EXPERIMENT.step,
        step_size=EXPERIMENT.step,
        parameter_set=SimpleNamespace(parameters=given),
    )
    for name in SIGNALS:
        if name in result.dtype.names:
            assert result[name][-1] == pytest.approx(ours[name], rel=1e-9), name
    assert "drive.x_enc" in result.dtype.names
