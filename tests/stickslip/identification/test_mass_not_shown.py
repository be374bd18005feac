"""A mass that does not show is a finding: friction is learned, and no loop is closed."""

import numpy as np
import pytest

from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.identification.estimation import LearnSettings, Task, learn
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.logs import Controller, Recording
from stickslip.servo.axis import ControlError
from stickslip.trial.compensator_trial import loops_of_log

N, T_S, F_C = 4000, 5e-3, 2.0


def slow(mass):
    """Return a log of a slow motion whose force has noise, and a mass of this size."""
    t = np.arange(N) * T_S
    rate = 2.0 * np.pi * 0.3
    x, v = 0.05 * np.sin(rate * t), 0.05 * rate * np.cos(rate * t)
    noise = 0.1 * np.random.default_rng(5).standard_normal(N)
    return Recording(t, x, F_C * np.sign(v) + mass * -(rate**2) * x + noise, source="slow.csv")


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "spoils"), [(-0.02, ""), (-5.0, "intervals")])
def test_friction_is_learned_without_a_mass(mass, spoils):
    recording = slow(mass)
    with candidate_fmus("coulomb_stribeck") as fmus:
        settings = LearnSettings(law="coulomb_stribeck")
        found = learn(Task(fmus, recording, None, settings))
    [fault] = [one for one in found.faults if "m" in one.hides]
    assert fault.spoils == spoils
    assert found.known["m"].identifiability == NOT_IDENTIFIABLE
    assert found.known["F_c"].value == pytest.approx(F_C, rel=0.1)
    reading = type("Reading", (), {"recording": recording, "controller": Controller(), "tau_i": 0})
    with pytest.raises(ControlError, match="the mass does not show"):
        loops_of_log(reading, found)
