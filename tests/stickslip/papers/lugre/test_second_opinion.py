"""FMPy steps the compensator over the commands of the loop, and gets the same bits, or says so."""

import fmpy
import numpy as np
import pytest

from stickslip import models
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.motions import TRAINING, VALIDATION
from stickslip.papers.lugre.fmpy_check import second_opinion
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.systems import FEEDS, Compensator, deployed, paper_loop
from stickslip.servo.velocity_loop import design_velocity_loop

pytestmark = pytest.mark.slow

T = np.arange(1401) * LOOP.T_s
COMMANDS = {
    "training": TRAINING.sample(T),
    "trapezoid": VALIDATION.sample(T),
    "not at rest": 0.02 + 0.01 * np.sin(40 * T),
}
TUNED = {name: 1.07 * PAPER[name] for name in LUGRE}


def opinion(fmus, folder, own, feed="nominal", fmi=2):
    """Return FMPy's opinion of a compensator with ``own`` start values, the loop having TUNED."""
    loop = design_velocity_loop(Datasheet().axis(PAPER["m"], PAPER["b"]), LOOP)
    known = loop if feed == "nominal" else None
    block = deployed(Compensator("compensator", "compensator", own), known, loop.T_s)
    values = {"lead": loop.axis.tau_i, **block.values}
    fmu = models.build_fmu(block.model, folder, start=values, fmi=fmi, called="compensator")
    return second_opinion(fmu, paper_loop(fmus, loop, TUNED, feed), loop, COMMANDS)


@pytest.mark.parametrize("feed", FEEDS)
@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_computes_the_same_bits(fmus, tmp_path, capfd, feed, fmi):
    found = opinion(fmus, tmp_path, TUNED, feed, fmi)
    assert found.tool == f"FMPy {fmpy.__version__}"
    assert found.comparisons.keys() == COMMANDS.keys()
    for comparison in found.comparisons.values():
        assert (comparison.samples, comparison.different, comparison.largest) == (len(T), 0, 0.0)
    assert "missing input" not in "".join(capfd.readouterr())


@pytest.mark.parametrize("name", ["F_c", "sigma_0"])
def test_another_parameter_in_the_last_digits_is_seen(fmus, tmp_path, name):
    other = {**TUNED, name: TUNED[name] * (1 + 1e-12)}
    for comparison in opinion(fmus, tmp_path, other).comparisons.values():
        assert comparison.different > 100
        assert 0.0 < comparison.largest < 1e-9
