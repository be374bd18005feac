"""A signal that is added to the controller's output or to its command, which the loop receives."""

from dataclasses import replace

import drives
import numpy as np
import pytest

from stickslip.identification.criteria.controller_check import check_controller
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.logs import Recording

T = np.arange(6000) * drives.T_S
COMMAND = 0.01 * np.sin(2 * np.pi * 1.3 * T)
DITHER = 4.0 * np.sign(np.sin(2 * np.pi * 23.0 * T))
PULSES = 0.004 * (np.sin(2 * np.pi * 3.1 * T) > 0.8)
VALUES = {
    name: drives.STAGE[name] for name in ("m", "b", "F_s", "F_c", "v_s", "sigma_0", "sigma_1")
}


@pytest.fixture(scope="module", params=["force", "velocity"])
def log(request):
    """Return a recording of an independent drive with an added signal, and without its role."""
    added = {f"added_{request.param}": DITHER if request.param == "force" else PULSES}
    shown = drives.run(
        "lugre",
        COMMAND + added.get("added_velocity", 0.0),
        feedforward=added.get("added_force"),
        uneven=0.0,
        encoder=1e-9,
    )
    plain = Recording(shown["t"], shown["position"], shown["applied"], velocity_command=COMMAND)
    return replace(plain, **added), plain


def test_the_controller_with_what_was_added_commands_the_force(log, candidates):
    known, plain = (check_controller(candidates, one, drives.GAINS).error for one in log)
    assert known < 1e-3
    assert plain > 10 * known


def test_the_loop_follows_what_was_added(log, candidates):
    errors = []
    for one in log:
        with KnownLoop(candidates, one, drives.GAINS) as loop:
            position = loop.run({**VALUES, "F_0": 0.0, "delay": 1e-7})["candidate.x_enc"]
        errors.append(np.std(position - one.position) / np.std(one.position))
    known, plain = errors
    assert known < 2e-3
    assert plain > 10 * known
