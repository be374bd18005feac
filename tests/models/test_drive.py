"""The drive, what each switch adds, and the stage that it is without them."""

import numpy as np
import pytest

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
