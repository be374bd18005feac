"""The same fit estimates the parameters of any law, as its law.toml describes them."""

import numpy as np
import pytest
from drives import GAINS, STAGE, run

from stickslip.catalog.parameters import ParameterSpace
from stickslip.identification.estimation import LearnSettings, Task, candidate_fmus, learn
from stickslip.identification.fitting.fit import fit
from stickslip.identification.fitting.search import select, variants
from stickslip.logs import Recording
from stickslip.models.export.law import read_law
from stickslip.planning import Limits, plan
from tests.kept import further

DAHL = """
title = "Dahl"
description = "Presliding hysteresis that ends at Coulomb friction"
steady = "coulomb"
passive = true
smooth = true
[states.F_d]
unit = "N"
description = "Force of the contact"
[force]
depends = { F_d = "constant" }
uses = []
"""
BRANCHES = """
title = "Two branches"
description = "Saturating springs in parallel, with a linear coordinate and a bound"
steady = "coulomb"
passive = true
smooth = false
[force]
depends = { v = "dependent" }
uses = ["F_c", "F_2", "k_1", "k_2", "offset"]
"""


def table(name, unit, start, **keys):
    lines = [f'unit = "{unit}"', f"start = {start}", "min = -1e9", "max = 1e9"]
    keys = {"description": name, "symbol": name, "coordinate": "log", **keys}
    lines += [f"{key} = {value!r}" for key, value in keys.items()]
    return "\n".join([f"[parameters.{name}]", *lines, ""])


LAWS = {
    "dahl": DAHL
    + table("sigma_0", "N/m", 1e5, shown_by="presliding moves")
    + table("F_c", "N", 5.0, shown_by="constant speeds")
    + table("i", "1", 1.0, coordinate="linear", choices=[1.0, 2.0]),
    "branches": BRANCHES
    + table("F_2", "N", 9.0, shown_by="slow reversals", at_least="F_c")
    + table("F_c", "N", 5.0, shown_by="constant speeds")
    + table("k_1", "N/m", 1e5, shown_by="presliding moves")
    + table("k_2", "N/m", 1e5, shown_by="presliding moves")
    + table("offset", "N", 0.0, shown_by="constant speeds", coordinate="linear")
    + table("k_3", "N/m", 7.0),
}
T_S = 1e-3
T = T_S * np.arange(4000)
X = 2e-4 * np.sin(9.0 * T) + 5e-5 * np.sin(31.0 * T)


def dahl(p):
    """Dahl's contact force along the motion, in closed form over each step for i = 1."""
    F = np.zeros_like(X)
    for k, dx in enumerate(np.diff(X)):
        sign = np.sign(dx)
        steps = 1 if p["i"] == 1.0 else 8
        F[k + 1] = F[k]
        for _ in range(steps):
            share = 1.0 - sign * F[k + 1] / p["F_c"]
            if p["i"] == 1.0:
                share *= np.exp(-p["sigma_0"] * abs(dx) / p["F_c"])
            else:  # d share / dx = -sigma_0 / F_c share^2
                share /= 1.0 + p["sigma_0"] * abs(dx) / steps / p["F_c"] * share
            F[k + 1] = sign * p["F_c"] * (1.0 - share)
    return F


def branches(p):
    first, second = p["F_c"] * np.tanh(p["k_1"] * X / p["F_c"]), p["F_2"] * np.tanh(p["k_2"] * X)
    return first + second + p["offset"]


class Force:
    """Measured minus predicted force, for a law written in Python."""

    name = "force"
    every = 1

    def __init__(self, space, force, measured):
        self.space, self.force, self.measured = space, force, measured

    def residual(self, values):
        drive = values["m"] * np.cos(T) + values["b"] * np.sin(5.0 * T) + values["F_0"]
        return self.measured - self.force(values) - drive - values["delay"] * T

    def map(self, points):
        return [self.residual(values) for values in points]

    def over(self, space):
        return Force(space, self.force, self.measured)


@pytest.fixture
def space_of(tmp_path):
    def make(name):
        (tmp_path / name).mkdir()
        (tmp_path / name / "law.toml").write_text(LAWS[name])
        return ParameterSpace.of(read_law(tmp_path / name))

    return make


DRIVE = {"m": 2.0, "b": 0.5, "F_0": 0.3, "delay": 0.1}


@pytest.mark.slow
@pytest.mark.parametrize("i", [2.0, *further(1.0)])
def test_dahl_is_estimated_with_its_exponent(space_of, i):
    truth = {"sigma_0": 2e5, "F_c": 6.0, "i": i, **DRIVE}
    space = space_of("dahl")
    blank = Force(space, dahl, np.zeros_like(T))
    noise = np.random.default_rng(0).normal(0.0, 0.01, len(T))
    criterion = Force(space, dahl, noise - blank.residual(truth))
    start = space.encode({**truth, "sigma_0": 1e5, "F_c": 5.0, "m": 1.0, "i": 1.0})
    selection = select(variants(criterion, fit(criterion, [start])))
    assert selection.fit.parameters == pytest.approx(truth, rel=0.01)
    errors = selection.fit.errors()
    for name in space.names:
        assert abs(selection.fit.parameters[name] - truth[name]) < 4.0 * errors[name], name


@pytest.mark.slow
def test_a_dahl_drive_of_another_program_is_estimated_by_its_law():
    """Recorded without damping of the bristles, which Dahl's law does not have.

    The encoder rounds, as ours does: another phase, which a log does not tell, moves m by 0.04 %.
    """
    command = plan(Limits(duration=8.0))["velocity_command"].to_numpy()
    drive = run("dahl", command, uneven=0.0, sigma_1=0.0, phase=0.5)
    recording = Recording(
        drive["t"],
        drive["position"],
        force=drive["applied"],
        velocity_command=drive["v_cmd"],
        encoder_step=4e-7,
        source="dahl",
    )
    with candidate_fmus("dahl") as fmus:
        learned = learn(Task(fmus, recording, GAINS, LearnSettings(law="dahl")))
    assert learned.criterion == "output error"
    assert learned.known.keys() == {"sigma_0", "F_c", "m", "b"}
    for name, known in learned.known.items():
        apart = abs(known.value - STAGE[name])
        assert apart < 3.0 * known.standard_error, name
        assert apart < 0.05 * STAGE[name], name
