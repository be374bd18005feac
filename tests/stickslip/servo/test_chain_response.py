"""The robustness of a loop as the FMUs of its compensators show it."""

import numpy as np
import pytest

from stickslip import models
from stickslip.servo.chain_response import LOWEST, SAMPLES, ChainResponse
from stickslip.servo.sensitivity import OpenLoop, peak_sensitivity
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter
from stickslip.thresholds import offer

COMPENSATORS = [name for name in models.model_names() if models.load_model(name).ports]


def observer(loop, rate, order=1):
    weights = FilterSpecification(4e-7, 0.05, rate, order)
    return Observer(design_velocity_filter(loop.axis, loop.T_s, weights))


def values(observer):
    return {f"observer.{name}": value for name, value in observer.parameters().items()}


@pytest.mark.parametrize("mass", [0.3, 0.5, 1.0, 4.0])
@pytest.mark.parametrize(
    ("model", "rate", "order"),
    [
        *((model, rate, 1) for model in ("dob", "coulomb_observer") for rate in (0.3, 5.0, 50.0)),
        ("dob", 300.0, 2),
    ],
)
def test_it_is_that_of_the_linear_design(fmus, loop, model, rate, order, mass):
    """In motion of one direction the Coulomb observer is the disturbance observer."""
    designed = observer(loop, rate, order)
    with ChainResponse(fmus, loop, [Compensator("observer", model)]) as response:
        found = response.of(loop, values(designed), 6.0, mass * loop.axis.m).peak
    f = np.arange(LOWEST, SAMPLES + 1) / (2 * SAMPLES * loop.T_s)
    opened = OpenLoop(loop, mass * loop.axis.m, f)
    expected = opened.response(designed).peak if opened.stable(designed) else np.inf
    assert found == pytest.approx(expected, rel=1e-3)


def test_a_faster_observer_lets_more_noise_through_and_margins_are_those_of_the_loop(fmus, loop):
    with ChainResponse(fmus, loop, [Compensator("observer", "dob")]) as response:
        noise = [response.of(loop, values(observer(loop, r)), 6.0).noise for r in (0.05, 5.0, 50.0)]
    assert np.all(np.diff(noise) > 0.1 * noise[0])
    with ChainResponse(fmus, loop, []) as response:
        found = response.of(loop, {}, 6.0)
    margins = loop.margins()
    assert np.degrees(found.phase_margin) == pytest.approx(margins["phase_margin_deg"], abs=0.05)
    assert 20.0 * np.log10(found.gain_margin) == pytest.approx(margins["gain_margin_dB"], abs=0.05)


@pytest.mark.parametrize("model", COMPENSATORS)
def test_start_values_leave_the_papers_loop_robust(fmus, loop, model):
    """What feeds back costs sensitivity, pure feedforward none."""
    with ChainResponse(fmus, loop, [Compensator("one", model)]) as response:
        peak = response.of(loop, {}, 6.0).peak
    alone = peak_sensitivity(loop)
    assert alone * 0.999 < peak <= offer.SENSITIVITY
    takes = set(models.load_model(model).ports.inputs.values())
    feeds_back = bool(takes & {"x_enc", "F_motor", "u"}) and model != "adaptive_scale"
    assert (peak > 1.0002 * alone) == feeds_back
