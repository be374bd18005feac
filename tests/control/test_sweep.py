"""The measured frequency response, against designs and describing functions."""

import math

import control
import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.cosim.control import measure_response
from stickslip.presentation.bode import draw_bode
from tests.control.closed_loop import ideal_servo
from tests.cosim.single import exposed

T_S = 5e-4
F = np.geomspace(2.0, 450.0, 9)


def test_a_linear_system_shows_its_response(tmp_path):
    """Continuous and held: what python-control samples, at every amplitude and offset."""
    plant = control.tf([4e4, 2e6], [1.0, 60.0, 4e4], inputs="u", outputs="y", name="plant")
    system = exposed(models.export_lti(plant, tmp_path), name="plant")
    found = measure_response(system, "u", ["plant.y"], F, 3.0, step=T_S, offset=1.0, settle=1.0)
    sampled = control.sample_system(plant, T_S, method="zoh")
    expected = sampled(np.exp(2j * np.pi * found.f * T_S))
    np.testing.assert_allclose(found.response("plant.y"), expected, rtol=1e-9)
    np.testing.assert_allclose(abs(found.response("plant.y", "plant.y")), 1.0)
    assert found.distortion["plant.y"].max() < 1e-6
    assert found.drift["plant.y"].max() < 1e-9
    data = found.frd("plant.y")
    np.testing.assert_allclose(data(2j * np.pi * found.f), expected, rtol=1e-9)
    assert data.dt == T_S


def test_a_limit_shows_its_describing_function(fmus):
    """u = 205 N at most: N(A) = 2/pi (asin(s) + s sqrt(1 - s^2)) K with s = limit / (K A)."""
    parameters = {"K_p": 1e3, "K_i": 0.0, "tau_f": 0.0, "T_s": 1e-4}
    system = exposed(fmus / "velocity_controller.fmu", parameters, "controller")
    limit = cosim.Fmu(fmus / "velocity_controller.fmu").variables["u_max"].start
    for amplitude in (0.1, 0.3, 2.0):
        found = measure_response(
            system, "v_cmd", ["controller.u"], [1.0], amplitude, step=1e-4, periods=2
        )
        s = min(1.0, limit / (1e3 * amplitude))
        corner, rise = math.asin(s), s * math.sqrt(1 - s**2)
        gain = 2 / math.pi * (corner + rise)
        assert abs(found.response("controller.u")[0]) == pytest.approx(1e3 * gain, rel=1e-5)
        power = s**2 * (1 - 2 * corner / math.pi) + (corner - rise) / math.pi
        distortion = math.sqrt(max(power / (0.5 * gain**2) - 1, 0.0))
        assert found.distortion["controller.u"][0] == pytest.approx(distortion, abs=1e-5)
    assert distortion > 0.4


def test_the_peak_of_a_resonance_is_found_by_settling_long_enough(tmp_path, caplog):
    """Damping of 0.1 %: transients at 10 Hz last for 16 s, and beat with a sine beside it."""
    omega, f = 20 * np.pi, [3.0, 9.9, 10.0]
    poles = [1.0, 0.002 * omega, omega**2]
    plant = control.tf([0.00306 * omega**2], poles, inputs="u", outputs="y", name="plant")
    system = exposed(models.export_lti(plant, tmp_path), name="plant")
    found = measure_response(system, "u", ["plant.y"], f, 1.0, step=1e-3)
    expected = control.sample_system(plant, 1e-3, method="zoh")(np.exp(2e-3j * np.pi * found.f))
    np.testing.assert_allclose(found.response("plant.y"), expected, rtol=1e-4)
    assert abs(expected[2]) == pytest.approx(1.53, rel=1e-3)
    assert not caplog.records
    measure_response(system, "u", ["plant.y"], f[2:], 1.0, step=1e-3, longest=1.0)
    assert "plant.y has not settled after 0.8 s" in caplog.text


def test_a_system_that_did_not_settle_drifts(tmp_path):
    slow = control.tf([1.0], [10.0, 1.0], inputs="u", outputs="y", name="slow")
    system = exposed(models.export_lti(slow, tmp_path), name="slow")
    drift = [
        measure_response(
            system, "u", ["slow.y"], [5.0], 1.0, step=0.01, settle=s, longest=0.0
        ).drift["slow.y"][0]
        for s in (0.0, 100.0)
    ]
    assert drift[0] > 100 * drift[1]


@pytest.mark.parametrize(
    ("f", "periods", "message"),
    [
        ([600.0], 8, "up to 500 Hz, a quarter of the sample rate; got 600"),
        ([0.0, 1.0], 8, "must lie above 0"),
        ([1.0], 3, "periods is 3; expected an even number"),
    ],
)
def test_what_cannot_be_measured_is_told(f, periods, message, fmus, loop):
    with pytest.raises(cosim.ExperimentError, match=message):
        measure_response(
            ideal_servo(fmus, loop), "v_cmd", ["drive.v"], f, 0.01, step=T_S, periods=periods
        )


def test_the_loop_of_fmus_shows_the_designed_bode_plot(fmus, loop):
    found = measure_response(ideal_servo(fmus, loop), "v_cmd", ["drive.v"], F, 0.005, step=T_S)
    designed = loop.nominal(np.exp(2j * np.pi * found.f * T_S))
    tolerance = 1e-4 if loop.axis.tau_i > 0.0 else 1e-5
    np.testing.assert_allclose(found.response("drive.v"), designed, rtol=0, atol=tolerance)
    figure = draw_bode(loop.nominal, {"measured": (found, "drive.v")}, distortion=True)
    gain, phase, distortion = figure.axes
    assert gain.get_ylabel() == "Gain [dB]"
    assert (phase.get_ylabel(), distortion.get_ylabel()) == ("Phase [deg]", "Distortion [%]")
    for axes, off in ((gain, 0.05), (phase, 0.5)):
        designed, measured = axes.lines
        expected = np.interp(np.log(found.f), np.log(designed.get_xdata()), designed.get_ydata())
        np.testing.assert_allclose(measured.get_ydata(), expected, atol=off)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["designed", "measured"]
