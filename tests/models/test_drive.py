"""The drive, what each switch adds, and the stage that it is without them."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip import models
from tests.cosim.single import one

STEP = 5e-4  # s
IDEAL = {"drive.current_loop": False, "drive.dac": False, "drive.encoder": False}
RECORD = ("drive.x_enc", "drive.F_m", "drive.F_f", "drive.x", "drive.v", "drive.z")


def force(t: np.ndarray) -> np.ndarray:
    return 20 * np.sin(15 * t) * np.cos(2 * t)


@pytest.fixture
def run(alone):
    """Run the drive: ``run(u, stop=1.0, F_c=3.0)``; u is an array, a function of time, a number."""

    def run(u=force, stop=1.0, step=STEP, **parameters):
        with alone("drive", RECORD, step=step, stop=stop) as simulation:
            values = {f"drive.{name}": value for name, value in parameters.items()}
            return simulation.run(values, {"u": u})

    return run


def test_without_its_extras_it_is_the_stage(alone):
    with alone("drive", RECORD, step=STEP, stop=2.0) as simulation:
        drive = simulation.run(IDEAL, {"u": force})
    with alone("stage", step=STEP, stop=2.0) as simulation:
        stage = simulation.run(inputs={"u": force})
    for name in ("x", "v", "F_f"):
        np.testing.assert_array_equal(drive[f"drive.{name}"], stage[f"stage.{name}"])
    np.testing.assert_array_equal(drive["drive.x_enc"], drive["drive.x"])
    np.testing.assert_array_equal(drive["drive.F_m"][1:], force(simulation.time)[:-1])


def test_force_never_exceeds_the_peak(run):
    result = run(lambda t: 1000 * np.sin(40 * t), current_loop=False)
    assert result["drive.F_m"].max() == 205.0
    assert result["drive.F_m"].min() == -205.0
    assert run(1000.0, u_max=50.0, current_loop=False)["drive.F_m"][-1] == 50.0


@pytest.mark.parametrize("change", [{"encoder": False}, {"encoder_step": 1e-3}, {"noise": True}])
def test_what_is_measured_does_not_move_the_mass(run, change):
    """Open loop, the true motion knows nothing of encoder and noise."""
    plain, changed = run(), run(**change)
    assert not np.array_equal(plain["drive.x_enc"], changed["drive.x_enc"])
    for name in ("x", "v", "F_f"):
        np.testing.assert_array_equal(plain[f"drive.{name}"], changed[f"drive.{name}"])


SWITCHES = {
    "asymmetric": "asymmetry",
    "position_dependent": "position_amplitude",
    "ripple": "ripple_amplitude",
    "noise": "noise_x",
}


@pytest.mark.parametrize("switch", SWITCHES)
def test_a_switch_that_is_off_hides_its_size(run, switch):
    plain = run()
    np.testing.assert_array_equal(plain.values, run(**{SWITCHES[switch]: 0.3}).values)
    assert not np.array_equal(plain.values, run(**{switch: True}).values)


def test_friction_varies_along_the_guide(run):
    """Slow sliding: F_f = F_c (1 + amplitude sin(2 pi x / period)), in phase with the position."""
    result = run(
        12.0,
        stop=4.0,
        b=300.0,
        sigma_1=0.0,
        position_dependent=True,
        position_amplitude=0.3,
        position_period=0.02,
    )
    sliding = result.time > 0.5
    expected = 5.999 * (1 + 0.3 * np.sin(2 * np.pi * result["drive.x"] / 0.02))
    assert np.ptp(result["drive.x"][sliding]) > 0.04
    np.testing.assert_allclose(result["drive.F_f"][sliding], expected[sliding], rtol=5e-3)


@pytest.mark.parametrize("law", ["lugre", "coulomb_stribeck", "gms"])
def test_friction_falls_as_the_guide_gets_warm(with_law, law):
    """At a steady speed F_f = F_c (1 - drift (1 - e^(-t / drift_time))), whatever the law."""
    size = {"drift": 0.3, "drift_time": 0.5, "b": 100.0, "current_loop": False, "sigma_1": 0.0}
    known = {v.name for v in models.load_model("drive", law).variables}
    given = {k: v for k, v in size.items() if k in known}
    system = one(with_law("drive", law), given, "u", "drive")
    result = system.prepare(step=STEP, stop=3.0).run(inputs={"u": 12.0})
    late = result.time > 0.6
    expected = 5.999 * (1.0 - 0.3 * (1.0 - np.exp(-result.time / 0.5)))
    np.testing.assert_allclose(result["drive.F_f"][late], expected[late], rtol=1e-3)


def test_friction_rises_with_the_load(run):
    """Steady sliding: mu |load| more."""
    size = {"b": 100.0, "mu": 0.01, "stop": 3.0}
    for load in (0.0, 80.0, -80.0):
        assert run(12.0, load=load, **size)["drive.F_f"][-1] == pytest.approx(
            5.999 + 0.01 * abs(load), rel=1e-6
        )


def test_the_encoder_errs_within_its_signal_period(run):
    result = run(encoder=False, sde=4e-8, sde_period=2e-5)
    x = result["drive.x"]
    error = result["drive.x_enc"] - x
    np.testing.assert_allclose(error, 4e-8 * np.sin(2 * np.pi * x / 2e-5), atol=1e-15)
    assert error.max() > 3.9e-8
    np.testing.assert_array_equal(x, run(encoder=False)["drive.x"])


def test_ripple_pushes_with_the_period_of_the_magnets(run):
    """m a + b v + F_f = u + amplitude sin(2 pi x / period), read off the motion."""
    result = run(
        20.0,
        stop=1.0,
        b=0.0,
        ripple=True,
        ripple_amplitude=3.0,
        ripple_period=0.032,
        current_loop=False,
    )
    x = result["drive.x"]
    pushed = 5.557 * np.gradient(result["drive.v"], STEP) + result["drive.F_f"]
    expected = 20.0 + 3.0 * np.sin(2 * np.pi * x / 0.032)
    moving = slice(200, -1)
    assert np.ptp(x) > 0.3
    assert abs(pushed - expected)[moving].max() < 0.05
    assert result["drive.F_m"][-1] == 20.0


def test_an_arm_with_cogging_swings_as_scipy_says(run):
    """m a + b v + F_pos(x) = u, with hardly any friction."""
    m, b, pitch = 0.5, 0.1, 0.3
    values = {"F_0": 0.5, "g_s": 8.0, "g_c": -3.0, "cogging_s[2]": 0.7, "cogging_c[1]": -1.1}

    def rate(_: float, y: np.ndarray) -> list[float]:
        x, v = y
        held = 0.5 + 8.0 * np.sin(x) - 3.0 * np.cos(x)
        held += 0.7 * np.sin(4 * np.pi * x / pitch) - 1.1 * np.cos(2 * np.pi * x / pitch)
        return [v, (2.0 - b * v - held) / m]

    small = {"F_c": 1e-9, "F_s": 1e-9, "sigma_0": 1e-3, "sigma_1": 0.0}
    loop = {"current_loop": False, "dac": False, "encoder": False, "m": m, "b": b, "pitch": pitch}
    found = run(2.0, stop=3.0, **small, **loop, **values)
    swing = solve_ivp(rate, (0.0, 3.0), [0.0, 0.0], t_eval=found.time, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(found["drive.x"], swing.y[0], atol=2e-4)
    assert np.ptp(swing.y[0]) > 1.0


def test_noise_has_the_stated_deviation(run):
    quiet = run(0.0, stop=10.0, encoder=False)
    noisy = run(0.0, stop=10.0, encoder=False, noise=True, noise_x=2e-7, noise_F=0.1)
    n = len(quiet.time)
    for name, deviation in (("drive.x_enc", 2e-7), ("drive.F_m", 0.1)):
        noise = noisy[name] - quiet[name]
        assert noise.std() == pytest.approx(deviation, rel=5 / np.sqrt(2 * n))
        assert abs(noise.mean()) < 5 * deviation / np.sqrt(n)
    both = np.corrcoef(noisy["drive.x_enc"], noisy["drive.F_m"])[0, 1]
    assert abs(both) < 5 / np.sqrt(n)


def test_noise_is_a_function_of_its_seed(run):
    one, same, other = (run(noise=True, encoder=False, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.values, same.values)
    for name in ("drive.F_m", "drive.x_enc"):
        assert not np.array_equal(one[name], other[name])
