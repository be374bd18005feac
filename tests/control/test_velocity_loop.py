"""The designed loop against its specification, the same loop written out, and a loop of FMUs."""

import dataclasses
import math
import warnings

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.servo.axis import Axis, ControlError
from stickslip.servo.velocity_filter import FilterSpecification
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop
from tests.control.closed_loop import follow

T_S = 5e-4


def log_uniform(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log(low), math.log(high)).map(math.exp)


axes = st.builds(
    Axis,
    m=log_uniform(0.1, 100.0),
    b=st.just(0.0) | log_uniform(0.1, 1000.0),
    tau_i=st.just(0.0) | log_uniform(2e-5, 5e-4),
)
specifications = st.builds(
    LoopSpecification,
    bandwidth=log_uniform(5.0, 250.0),
    phase_margin=st.floats(10.0, 80.0),
    T_s=st.just(T_S),
    tau_f=st.just(0.0) | log_uniform(1e-4, 2e-3),
)


def transfer_function(axis: Axis, K_p: float, K_i: float, tau_f: float) -> control.TransferFunction:
    """Controller, axis and estimate as transfer functions in z; K_i per second on the error."""
    z = control.TransferFunction([1, 0], [1], T_S)
    controller = K_p + K_i * T_S * z / (z - 1)
    position = control.tf([1], [axis.tau_i, 1]) * control.tf([1], [axis.m, axis.b, 0])
    way = control.sample_system(position, T_S, method="zoh") * (z - 1) / z
    weight = 1 - math.exp(-T_S / tau_f) if tau_f > 0 else 1.0
    estimate = weight * z / (z - (1 - weight)) / T_S
    return controller * way * estimate


@pytest.mark.slow
@settings(max_examples=60)
@given(axes, specifications)
def test_meets_its_specification_or_says_that_it_cannot(axis, wanted):
    try:
        loop = design_velocity_loop(axis, wanted)
    except ControlError as error:
        message = str(error)
        assert "out of reach" in message or "unstable" in message
        return
    assert loop.K_p >= 0.0
    assert loop.K_i >= 0.0
    f = wanted.bandwidth
    z = np.exp(2j * np.pi * f * T_S)
    by_hand = transfer_function(axis, loop.K_p, loop.K_i, wanted.tau_f)
    # polynomials with zeros near 1 lose up to seven digits, the states of the loop none
    for system, within in ((by_hand, 1e-6), (loop.open_loop, 1e-9)):
        value = complex(system(z))
        assert abs(value) == pytest.approx(1.0, rel=within)
        margin = pytest.approx(wanted.phase_margin, abs=100 * within)
        assert np.degrees(np.angle(-value)) == margin
    figures = loop.margins()
    # A loop may cross 1 again; what is reported is then the smaller margin.
    assert abs(figures["phase_margin_deg"]) <= wanted.phase_margin + 1e-6
    assert max(abs(loop.nominal.poles())) < 1.0
    assert loop.nominal.dcgain() == pytest.approx(1.0, abs=1e-6)
    assert loop.compliance.dcgain() == pytest.approx(0.0, abs=1e-6)


def test_margins_are_those_of_python_control_and_a_sine_comes_out_at_minus_3_db(loop):
    by_hand = transfer_function(loop.axis, loop.K_p, loop.K_i, loop.tau_f)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it divides by the gain at half the sample rate, 0
        gain, phase, _, _, crossover, _ = control.stability_margins(by_hand)
    figures = loop.margins()
    assert figures["crossover_Hz"] == pytest.approx(crossover / (2 * np.pi), rel=1e-6)
    assert figures["phase_margin_deg"] == pytest.approx(phase, abs=1e-4)
    assert figures["gain_margin_dB"] == pytest.approx(20 * math.log10(gain), abs=1e-4)
    response = complex(loop.nominal(np.exp(2j * np.pi * figures["bandwidth_Hz"] * loop.T_s)))
    assert 20 * math.log10(abs(response)) == pytest.approx(10 * math.log10(0.5), abs=1e-9)


@pytest.mark.parametrize(("system", "size"), [("nominal", 1.0), ("compliance", 10.0)])
def test_a_command_and_a_force_do_what_the_difference_equations_say(loop, system, size):
    given = np.repeat(np.random.default_rng(0).normal(scale=size, size=60), 10)
    t, zeros = np.arange(len(given)) * loop.T_s, np.zeros_like(given)
    response = np.asarray(control.forced_response(getattr(loop, system), t, given).outputs)
    expected = follow(loop, *((given, zeros) if system == "nominal" else (zeros, given)))
    assert np.abs(expected).max() > 1e-3
    np.testing.assert_allclose(response, expected, rtol=0, atol=1e-11 if size == 1.0 else 1e-13)


@pytest.mark.parametrize(
    ("bandwidth", "phase_margin", "tau_f", "message"),
    [
        (250.0, 50.0, 5e-4, r"50 deg at 250 Hz is out of reach: .* leaves .* deg there; lower"),
        (250.0, 50.0, 2e-3, r"leaves -\d.* to -\d.* deg there; lower"),
        (1.0, 5.0, 0.0, r"5 deg at 1 Hz is out of reach: .* leaves .* deg there; raise"),
    ],
)
def test_says_what_can_be_reached(bandwidth, phase_margin, tau_f, message):
    axis = Axis(m=5.557, b=6.6135, tau_i=1e-4)
    with pytest.raises(ControlError, match=message):
        design_velocity_loop(axis, LoopSpecification(bandwidth, phase_margin, T_S, tau_f))


SPECIFICATION = LoopSpecification(125.0, 50.0)
AXIS = Axis(5.557, 6.6135)
FILTER = FilterSpecification(encoder_step=4e-7, force_noise=0.05, disturbance_rate=1.5)


@pytest.mark.parametrize(
    ("sound", "change", "message"),
    [
        (SPECIFICATION, {"bandwidth": 1000.0}, "bandwidth is 1000 Hz; expected .* and 1000 Hz"),
        (SPECIFICATION, {"T_s": 1e-8}, "between 1000 and 5e.07 Hz"),
        (SPECIFICATION, {"bandwidth": math.nan}, "bandwidth is nan Hz"),
        (SPECIFICATION, {"phase_margin": 0.0}, "is 0 deg; expected between 0 and 180"),
        (SPECIFICATION, {"T_s": 0.0}, "T_s is 0 s; expected above 0"),
        (SPECIFICATION, {"tau_f": -1e-3}, "tau_f is -0.001 s; expected 0 or above"),
        (AXIS, {"m": 0.0}, "m is 0 kg; expected above 0"),
        (AXIS, {"b": math.inf}, "b is inf N s/m"),
        (AXIS, {"tau_i": -1.0}, "tau_i is -1 s"),
        (FILTER, {"encoder_step": 0.0}, "encoder_step is 0 m; expected above 0"),
        (FILTER, {"force_noise": -1.0}, "force_noise is -1 N; expected 0 or above"),
        (
            FILTER,
            {"disturbance_rate": math.inf},
            r"disturbance_rate is inf N/s\^0.5; expected above",
        ),
    ],
)
def test_values_out_of_range(sound, change, message):
    with pytest.raises(ControlError, match=message):
        dataclasses.replace(sound, **change)
