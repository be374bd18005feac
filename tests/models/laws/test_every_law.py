"""What holds for every friction law in models/laws, with what its law.toml declares."""

import numpy as np
import pytest

from stickslip import models
from tests.cosim.single import one

SPECIFIED = {  # parameters of the values below that are not the start values
    "leuven": {"kappa[1]": 0.612839, "kappa[2]": 0.0, "kappa[3]": 0.0, "kappa[4]": 0.387161}
    | {"W[1]": 3.0 / 5.999}
}
RESTED = {"armstrong": {"gamma": 0.0}}  # static friction as after a long time at rest
LAWS = [models.load_law(name) for name in models.law_names()]
H = 5e-4  # s
every = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)


def level(law: models.Law, v: float) -> float:
    """Return the force that law.toml declares for a constant speed [N]."""
    p = {name: parameter.start[0] for name, parameter in law.parameters.items()}
    if law.steady == "coulomb":
        return float(np.sign(v) * p["F_c"])
    ratio = abs(v) / p["v_s"]
    share = 1 / (1 + ratio**2) if law.steady == "lorentz" else np.exp(-(ratio ** p["delta"]))
    return float(np.sign(v) * (p["F_c"] + (p["F_s"] - p["F_c"]) * share))


@every
@pytest.mark.parametrize("v", [2e-4, -1e-3, 0.05])
def test_a_constant_speed_ends_at_the_declared_force(follow, law, v):
    found = follow(law.name, H, np.full(12000, v), **RESTED.get(law.name, {}))
    assert found["F_mean"][-1] == pytest.approx(level(law, v), rel=1e-6)
    assert found["F_f"][-1] == pytest.approx(level(law, v), rel=1e-6)


@every
def test_at_rest_there_is_no_force_and_forward_and_backward_mirror_each_other(follow, law):
    rest = follow(law.name, H, np.zeros(50))
    assert not rest["F_mean"].any()
    assert not rest["F_f"].any()
    v = 0.02 * np.sin(np.arange(600) * 0.04) + 1e-3 * np.cos(np.arange(600) * 0.7)
    np.testing.assert_array_equal(
        follow(law.name, H, v)["F_mean"], -follow(law.name, H, -v)["F_mean"]
    )


@every
def test_the_mean_is_that_of_finer_steps(follow, law):
    """law_step is exact for a held velocity: dividing a step changes its mean by rounding only."""
    v = np.repeat(0.01 * np.sin(np.arange(60) * 0.4), 5)
    whole = follow(law.name, H, v)["F_mean"]
    parts = follow(law.name, H / 8, np.repeat(v, 8))["F_mean"].reshape(-1, 8).mean(axis=1)
    np.testing.assert_allclose(parts, whole, atol=1e-11)


@every
def test_passivity_is_as_declared(follow, law):
    """A passive law gives back at most what it was given; a README names what is not passive."""
    if not law.is_passive:
        assert "passive" in (law.folder / "README.md").read_text()
        return
    rng = np.random.default_rng(3)
    for _ in range(20):
        v = 10.0 ** rng.uniform(-5, -1) * np.repeat(rng.standard_normal(100), 20)
        energy = np.cumsum(follow(law.name, H, v)["F_mean"] * v * H)
        assert energy.min() >= -1e-15


@every
def test_a_share_of_the_force_is_that_share_at_every_motion(follow, law):
    start = {
        name if len(p.start) == 1 else f"{name}[{k + 1}]": value
        for name, p in law.parameters.items()
        for k, value in enumerate(p.start)
    }
    v = 0.01 * np.sin(np.arange(400) * 0.03)
    whole = follow(law.name, H, v, **start)["F_mean"]
    third = follow(law.name, H, v, **law.share(start, 1 / 3))["F_mean"]
    np.testing.assert_allclose(third, whole / 3, rtol=1e-9, atol=1e-12)
    hardly = follow(law.name, H, v, **law.share(start, 1e-10))["F_mean"]  # no value is too small
    assert np.max(np.abs(hardly)) < 1e-6 * np.max(np.abs(whole))


@every
def test_a_plant_rests_below_its_break_away_force_and_moves_above(push, law):
    rest, moved = (push(law.name, H, np.full(2000, u)) for u in (2.0, 12.0))
    assert abs(rest["v"][-1]) < 1e-4  # contacts without damping ring
    assert abs(rest["x"][-1]) < 5e-5
    assert moved["v"][-1] > 0.1


@every
def test_roughness_scales_the_declared_force(with_law, law):
    """The drive's asymmetry multiplies the steady force and leaves the stiffness."""
    extras = {"asymmetric": True, "asymmetry": 0.25, "dac": False, "current_loop": False}
    extras |= RESTED.get(law.name, {})
    system = one(with_law("drive", law.name), extras, "u", "drive")
    result = system.prepare(step=H, stop=2.0).run(inputs={"u": -20.0})
    assert result["drive.v"][-1] < -0.5
    assert result["drive.F_f"][-1] == pytest.approx(0.75 * level(law, -1.0), rel=1e-3)


TOLERANCE = {  # of a place in a motion [um]: of Rodas3 the last digit, or what switching leaves
    "lugre": 0.01,
    "elasto_plastic": 0.01,
    "coulomb_stribeck": 0.3,
    "armstrong": 1.0,
    "gms": 2.0,
}


@pytest.mark.parametrize(
    ("law", "x", "v"),
    [
        ("lugre", (4811.43, 24397.67, 6992.67, 30459.82, 3083.70), 41.4128),
        ("dahl", (5190.02, 25143.30, 6471.34, 30541.22, 2652.41), 43.2285),
        ("coulomb_stribeck", (0.00, 7319.09, -7246.40, 13067.32, -11306.69), 29.6673),
        ("leuven", (4549.26, 23824.20, 6329.35, 29317.74, 2710.73), 39.5777),
        ("elasto_plastic", (4407.32, 23583.65, 6699.54, 29664.32, 2770.14), 39.6690),
        ("gms", (5131.40, 25034.76, 8523.16, 32117.56, 3558.11), 41.6254),
        ("armstrong", (4696.52, 24179.08, 6938.78, 30091.24, 3008.83), 40.3385),
    ],
)
def test_a_motion_against_another_integrator(push, law, x, v):
    """Values of a Runge-Kutta method of order 4 at 1 us, written apart from this project.

    Those of armstrong: implicit midpoint at rest and backward Euler in motion, at 0.5 us.
    The tolerance is else the error of 10 midpoint sub-steps.
    """
    t = np.arange(4000) * H
    found = push(
        law,
        H,
        9.5 * np.sin(2 * np.pi * t) + 3.0 * np.sin(2 * np.pi * 3.3 * t),
        **SPECIFIED.get(law, {}),
    )
    places = [round(s / H) for s in (0.25, 0.5, 1.0, 1.5, 2.0)]
    np.testing.assert_allclose(
        1e6 * found["x"][places],
        x,
        atol=TOLERANCE.get(law, 0.06),
    )
    assert 1e3 * found["v"][2500] == pytest.approx(
        v, abs={"gms": 5e-3, "coulomb_stribeck": 1e-3, "armstrong": 1e-3}.get(law, 2e-4)
    )


STIFF = {  # contacts that deflect by nanometres, with damping where elements would ring for long
    "armstrong": {"k_t": 1e9, "sigma_t": 1e5},
    "gms": {"sigma_0": 1e9, "sigma_1": 0.0, "C": 1e9},
    **{law: {"sigma_0": 1e9, "sigma_1": 0.0} for law in ("elasto_plastic", "leuven", "lugre")},
}


@every
def test_a_stiff_contact_without_stribeck_effect_is_static_friction(push, law):
    """Dahl's law and what others become for F_s = F_c, against the events of Coulomb-Stribeck."""
    u = 12.0 * np.sin(2 * np.pi * 2.0 * np.arange(2000) * H)
    F_c = law.parameters["F_c"].start[0]
    stiff = STIFF.get(law.name, {"sigma_0": 1e9}) | {"F_s": F_c}
    own = {name: value for name, value in stiff.items() if name in law.parameters}
    event = push("coulomb_stribeck", H, u, F_s=F_c)["x"]
    assert np.ptp(event) > 0.015
    np.testing.assert_allclose(push(law.name, H, u, **own)["x"], event, atol=5e-5)


ORDER = {  # of the step, and of what the law moves by it
    "gms": (2, 3.0, 1e-3),
    "elasto_plastic": (3, 12.0, 10e-3),
    "lugre": (3, 12.0, 10e-3),
}


@every
def test_the_step_of_a_plant_has_its_order(push, law):
    """The midpoint rule and Heun's method have order 2, Rodas3 of one bristle has 3.

    12 N break away and accelerate for 10 ms. Where an element of gms begins to slip inside a step,
    the order is lost, so gms is only pushed in presliding. At a reversal no law has an order.
    """
    order, u, duration = ORDER.get(law.name, (2, 12.0, 10e-3))
    least = round(duration / 40e-6)
    ends = [
        push(law.name, duration / n, np.full(n, u))["v"][-1] for n in (least, 2 * least, 4 * least)
    ]
    found = np.log2((ends[0] - ends[1]) / (ends[1] - ends[2]))
    assert found == pytest.approx(order, abs=0.1)
