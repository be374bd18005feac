"""A loop with compensators in one call, against the designs that it is made of."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.servo.sensitivity import peak_sensitivity

IDEAL = {"F_s": 1e-9, "F_c": 1e-9, "sigma_0": 1e-3, "sigma_1": 0.0, "encoder": False, "dac": False}


@pytest.fixture(scope="module")
def loop():
    axis = ss.Axis(m=3.0, b=5.0, tau_i=2e-4)
    return ss.design_velocity_loop(axis, ss.LoopSpecification(80.0, 50.0, T_s=5e-4, tau_f=5e-4))


@pytest.fixture(scope="module")
def observer(loop):
    designed = ss.design_observer(loop, 4e-7, 4.0)
    return ss.Compensator("observer", "dob", designed.observer.parameters()), designed


def error(system, T_s):
    v_cmd = ss.Trapezoid(height=0.02, slope=0.1, plateau=0.1, begin=0.05)
    result = ss.simulate(system, stop=1.0, step=T_s, inputs={"v_cmd": v_cmd})
    return np.sqrt(np.mean((result["drive.v"] - result["nominal.v_r"]) ** 2))


@pytest.mark.parametrize("tau_i", [2e-4, 0.0])
def test_without_friction_it_is_the_nominal_loop(loop, tmp_path, tau_i):
    loop = loop.changed(axis=replace(loop.axis, tau_i=tau_i))
    system = ss.closed_loop(loop, folder=tmp_path, drive=IDEAL)
    result = system.simulate(stop=0.05, step=loop.T_s / 20, inputs={"v_cmd": 0.01})
    gap = (result["drive.v"] - result["nominal.v_r"])[::20]
    assert np.abs(gap).max() < 1e-6


@pytest.mark.parametrize("law", ["lugre", "gms"])
def test_feedforward_of_the_law_of_the_drive_removes_its_friction(loop, law, tmp_path):
    drive = {"F_c": 4.0}
    feedforward = ss.Compensator("ff", "compensator", drive, law=law)
    static = ss.Compensator("static", "static_feedforward", drive)
    plain, exact, rough = (
        error(ss.closed_loop(loop, chain, folder=tmp_path, law=law, drive=drive), loop.T_s)
        for chain in ([], [feedforward], [static])
    )
    assert exact < 0.3 * plain
    assert exact < rough < plain


def test_the_peak_sensitivity_is_that_of_the_design(loop, observer, tmp_path):
    dob, designed = observer
    alone = ss.robustness(loop, [], friction=4.0, folder=tmp_path)
    assert alone.peak == pytest.approx(peak_sensitivity(loop), rel=1e-3)
    both = [ss.Compensator("ff", "compensator", law="dahl"), dob]
    peaks = [ss.robustness(loop, both, friction=4.0, folder=tmp_path, m=m).peak for m in (2.7, 3.3)]
    assert max(peaks) == pytest.approx(designed.sensitivity, rel=2e-2)


def test_mistakes_are_one_line(loop, tmp_path):
    for wrong in ({"friction": -1.0}, {"friction": "x"}, {"friction": 4.0, "m": 0.0}):
        with pytest.raises(ss.Fault, match=r"expected (0 or more|a number|more than 0)"):
            ss.robustness(loop, [], folder=tmp_path, **wrong)
    with pytest.raises(ss.Fault, match="no variable 'F_k'"):
        ss.closed_loop(loop, folder=tmp_path, drive={"F_k": 1.0})
