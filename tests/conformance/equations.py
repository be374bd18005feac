"""The equations of the paper in numpy, for complex numbers too: derivatives and outputs."""

import functools
from collections.abc import Callable, Mapping

import numpy as np

Values = Mapping[str, complex]


Law = Callable[[complex, Values, Values], tuple[dict[str, complex], complex]]


def lugre(v: complex, x: Values, p: Values) -> tuple[dict[str, complex], complex]:
    """Return dz/dt, equation (2), and the friction force, equation (3)."""
    speed = v if np.real(v) >= 0 else -v
    g = p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((speed / p["v_s"]) ** p["delta"]))
    dz = v - p["sigma_0"] * speed / g * x["z"]
    fading = np.exp(-((v / p["v_d"]) ** 2)) if p["v_d"] else 1.0
    return {"der(z)": dz}, p["sigma_0"] * x["z"] + p["sigma_1"] * fading * dz


def dahl(v: complex, x: Values, p: Values) -> tuple[dict[str, complex], complex]:
    s = 1.0 if np.real(v) >= 0 else -1.0
    r = 1.0 - s * x["F_d"] / p["F_c"]
    rest = r if np.real(r) >= 0 else -r
    return {"der(F_d)": p["sigma_0"] * rest ** p["i"] * np.sign(np.real(r)) * v}, x["F_d"]


def elasto_plastic(v: complex, x: Values, p: Values) -> tuple[dict[str, complex], complex]:
    s = 1.0 if np.real(v) >= 0 else -1.0
    g = p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((s * v / p["v_s"]) ** p["delta"]))
    z, z_m, z_ba = s * x["z"], g / p["sigma_0"], p["z_ba"] * p["F_c"] / p["sigma_0"]
    alpha = 0.5 + 0.5 * np.sin(np.pi * (z - (z_m + z_ba) / 2) / (z_m - z_ba))
    alpha = 0.0 if np.real(z) <= z_ba else 1.0 if np.real(z - z_m) >= 0 else alpha
    dz = v * (1.0 - alpha * z / z_m)
    return {"der(z)": dz}, p["sigma_0"] * x["z"] + p["sigma_1"] * dz


def stage(law: Law, x: Values, p: Values) -> dict[str, complex]:
    rates, F_f = law(x["v"], x, p)
    dv = (x["u"] - p["b"] * x["v"] - F_f) / p["m"]
    return {"der(x)": x["v"], "der(v)": dv, **rates, "F_f": F_f, "x": x["x"], "v": x["v"]}


def compensator(law: Law, x: Values, p: Values) -> dict[str, complex]:
    rates, F_f = law(x["v"], x, p)
    total = F_f + p["b"] * x["v"]
    return {**rates, "F_f": total, "F_mean": total}


OF: dict[str, Callable[[Values, Values], dict[str, complex]]] = {
    "stage": functools.partial(stage, lugre),
    "compensator": functools.partial(compensator, lugre),
    "stage+dahl": functools.partial(stage, dahl),
    "compensator+dahl": functools.partial(compensator, dahl),
    "stage+elasto_plastic": functools.partial(stage, elasto_plastic),
    "compensator+elasto_plastic": functools.partial(compensator, elasto_plastic),
}


def jacobian(name: str, x: Values, p: Values) -> dict[str, dict[str, float]]:
    """Return the partial derivatives by complex steps: exact to rounding, no difference taken."""
    columns = {}
    for known in x:
        tiny = 1e-30
        bent = OF[name]({**x, known: x[known] + 1j * tiny}, p)
        columns[known] = {unknown: np.imag(value) / tiny for unknown, value in bent.items()}
    return {unknown: {known: columns[known][unknown] for known in x} for unknown in bent}
