"""What is learned of a drive with another friction law never makes that drive worse."""

from functools import cache

import numpy as np
import pandas as pd
import pytest
from drives import STAGE, T_S

import stickslip as ss
from campaigns.sound_drives import simulator
from campaigns.sound_drives.drives import Drive, write_log
from campaigns.sound_drives.evaluation import MOTIONS, motion
from stickslip.fmi.process import temporary_folder
from stickslip.learned.file import LearnedFile
from stickslip.servo.axis import Axis
from stickslip.servo.systems import build_fmus, feedforward
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop
from stickslip.studies.learn.folder import write_learned

pytestmark = [pytest.mark.slow, pytest.mark.thorough]

WORSE = 1.02
LOOP = design_velocity_loop(
    Axis(STAGE["m"], STAGE["b"], 0.0), LoopSpecification(60.0, 45.0, T_S, T_S)
)
CONTROL = {"K_p": LOOP.K_p, "K_i": LOOP.K_i, "K_x": 0.0}
GMS = Drive(
    name="gms",
    seed=1,
    law="gms",
    rotary=False,
    parameters={**STAGE, "sigma_1": 1000.0, "origin": 0.0, **CONTROL},
    noise_F=0.008 * STAGE["F_c"],
    speed=0.04,
    acceleration=2.0,
    stroke=0.1,
    bandwidth=60.0,
)


@pytest.fixture(scope="module")
def learned(tmp_path_factory):
    """LuGre learned of a drive with five Maxwell-slip elements and position dependence."""
    folder = tmp_path_factory.mktemp("log")
    write_log(GMS, folder, encoder_noise=0.0)
    known = ss.Description(controller="PI", gains=GMS.gains)
    return ss.learn(folder / "gms.csv", known)


@cache
def error(name, force=None):
    """Return the RMS of v minus that without friction [m/s], over friction within 1 %."""
    v_cmd, p, squares = motion(GMS, name), GMS.parameters, []
    linear = simulator.run("none", {**p, "encoder": 0.0}, v_cmd)["v"]
    for level in np.linspace(0.99, 1.01, 48):
        friction = {name: level * p[name] for name in ("F_c", "F_s")}
        F_ff = None if force is None else np.frombuffer(force)
        v = simulator.run("gms", {**p, **friction}, v_cmd, F_ff=F_ff)["v"]
        squares.append(np.mean((v - linear) ** 2))
    return np.sqrt(np.mean(squares))


def ratios(compensator):
    """Return the errors with a feedforward over those without, by motion."""
    with temporary_folder() as folder:
        build_fmus(folder, {}, "lugre")
        system, found = feedforward(folder, LOOP, compensator), []
        for name in MOTIONS:
            v_cmd = motion(GMS, name)
            stop, force = (len(v_cmd) - 1) * T_S, "compensator.F_mean"
            with system.prepare(step=T_S, stop=stop, record=(force,)) as simulation:
                given = simulation.run({}, LOOP.commands(v_cmd))[force]
            found.append(error(name, given.tobytes()) / error(name))
    return found


def test_f_s_that_does_not_show_is_f_c(learned):
    """The fit prefers 20 times F_c here; such a force pushed the drive."""
    estimation = learned.estimation
    fitted = estimation.fitted.plausible[0]
    assert fitted["F_s"] > 10.0 * fitted["F_c"]
    assert estimation.fitted.largest_friction == pytest.approx(8.999, rel=0.1)
    assert estimation.known["F_s"].identifiability == "not identifiable"
    assert learned.friction["F_s"] == learned.friction["F_c"] == estimation.known["F_c"].value
    assert "F_s = F_c is used" in estimation.known["F_s"].sentence
    assert learned.friction["F_c"] == pytest.approx(5.999, rel=0.15)


def test_the_drive_is_not_worse_with_what_is_written_but_with_the_fit(learned):
    assert not learned.refusal
    written = ratios(learned.compensator)
    assert max(written) <= WORSE
    assert np.exp(np.mean(np.log(written))) < 0.75
    fit = {name: learned.estimation.fitted.plausible[0][name] for name in learned.friction}
    assert max(ratios(fit)) > WORSE


def test_no_drive_of_the_family_is_beyond_the_log(learned):
    drives = learned.trial.drives
    assert {"lugre", "gms"} <= {drive.law for drive in drives}
    most = 1.5 * 1.3 * learned.estimation.fitted.largest_friction
    assert max(drive.parameters.get("F_s", 0.0) for drive in drives) <= most


@pytest.mark.usefixtures("without_pictures")
def test_export_tries_the_same_drives(learned, tmp_path):
    write_learned(learned, tmp_path)
    file = LearnedFile(tmp_path / "learned.json")
    assert file.drives == learned.trial.drives
    assert file.compensator == pytest.approx(learned.compensator)
    table = pd.read_csv(tmp_path / "tracking_error.csv")
    assert len(table) == (1 + len(learned.trial.others)) * 5 * len(learned.trial.drives)
    written = table[table["compensation"] == learned.trial.benefit.variant.name]
    assert (written["ratio"] <= WORSE).all()
