"""Writes each reference.csv of models/: what each model does in a short run, calculated without it.

    python tests/models/make_references.py [NAME ...]

Nothing here calls the C of models/: differential equations are solved by scipy's Radau at a
relative tolerance of 1e-10, the rest by numpy from the closed form or the difference equations.
Parameters are the start values of model.toml. Inputs hold from one row to the next.
"""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from stickslip import models
from stickslip.fmi.files import atomic_write
from stickslip.models.export.presentation import reference_file

ROOT = Path(models.__file__).parent

Columns = dict[str, np.ndarray]
Parameters = dict[str, float]
Network = Callable[..., np.ndarray]
STEP = 5e-4  # s
INSTANT = 1e-11  # s, in place of no lag
Z_UNIT = 1e-6  # the solver sees the bristle in um, so that one absolute tolerance fits all


def model_of(name: str) -> models.Model:
    """Return the model that a table is of: for a law's, the feedforward compensator."""
    return (
        models.load_model("compensator", name)
        if name in models.law_names()
        else models.load_model(name)
    )


def start_values(name: str) -> Parameters:
    """Return the parameters of a model, or of a law, by name."""
    return {v.name: v.start for v in model_of(name).variables if v.role == "parameter"}


def array(p: Parameters, name: str, *sizes: int) -> np.ndarray:
    """Return the elements of an array of parameters."""
    keys = (",".join(str(i + 1) for i in index) for index in np.ndindex(*sizes))
    return np.reshape([p[f"{name}[{key}]"] for key in keys], sizes)


def ahead(v: np.ndarray, lead: float) -> np.ndarray:
    """Return the means of velocities over the periods that end, a time [s] ahead."""
    last = np.append(v[0], v[:-1])
    return (v + last) / 2 + lead * (v - last) / STEP


def stribeck(v: np.ndarray | float, p: Mapping[str, complex]) -> np.ndarray:
    """Return g(v) [N], equation (4)."""
    return p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((abs(v) / p["v_s"]) ** p["delta"]))


def bristle_rate(v: np.ndarray, z: np.ndarray, p: Parameters) -> np.ndarray:
    """Return dz/dt [m/s], equation (2)."""
    return v - p["sigma_0"] * abs(v) / stribeck(v, p) * z


def damping(v: np.ndarray | float, p: Parameters) -> np.ndarray | float:
    """Return the coefficient of the bristle's damping [N s/m], which may fade with the velocity."""
    return p["sigma_1"] * (np.exp(-((v / p["v_d"]) ** 2)) if p["v_d"] else 1.0)


def friction(v: np.ndarray, z: np.ndarray, p: Parameters) -> np.ndarray:
    """Return F_f [N], equation (3)."""
    return p["sigma_0"] * z + damping(v, p) * bristle_rate(v, z, p)


def hold(
    y: np.ndarray,
    p: Parameters,
    force: Callable[[float, float], float],
    rough: Callable[[float, float, float], float] = lambda *_: 1.0,
) -> np.ndarray:
    """Return x, v, z after one step under a force [N], a function of the time in it and the place.

    The guide multiplies the steady friction by ``rough``, of time, place and velocity.
    """

    def motion(t: float, y: np.ndarray) -> list[float]:
        x, v, z = y[0], y[1], y[2] * Z_UNIT
        there = scaled(p, rough(t, x, v))
        dv = (force(t, x) - p["b"] * v - friction(v, z, there)) / p["m"]
        return [v, dv, bristle_rate(v, z, there) / Z_UNIT]

    begin = y / [1.0, 1.0, Z_UNIT]
    end = solve_ivp(motion, (0.0, STEP), begin, "Radau", rtol=1e-10, atol=1e-13).y[:, -1]
    return end * [1.0, 1.0, Z_UNIT]


def scaled(p: Parameters, factor: float) -> Parameters:
    """Return the parameters of a contact whose steady friction is so many times as large."""
    return p if factor == 1.0 else {**p, "F_s": factor * p["F_s"], "F_c": factor * p["F_c"]}


def stage(p: Parameters) -> Columns:
    """Break away, turn, stop."""
    t = np.arange(201) * STEP
    u = 15.0 * np.sin(2 * np.pi * 14.0 * t) * np.where(t < 0.08, 1.0, 0.2)
    y = [np.zeros(3)]
    for force in u[:-1]:
        y.append(hold(y[-1], p, lambda *_, force=force: force))
    x, v, z = np.transpose(y)
    return {"time": t, "u": u, "x": x, "v": v, "F_f": friction(v, z, p)}


def drive(p: Parameters, n: int = 201) -> Columns:
    """Move as the stage, behind DAC and motor lag, on a guide that pushes and is rough."""
    t = np.arange(n) * STEP
    u = 15.0 * np.sin(2 * np.pi * 14.0 * t)
    target = np.rint(u / p["dac_step"]) * p["dac_step"] if p["dac"] else u
    target = np.clip(target, -p["u_max"], p["u_max"])
    lag = p["tau_i"] if p["current_loop"] else INSTANT

    def rough(t: float, x: float, v: float) -> float:
        weight = abs(p["g_s"] * np.sin(x) + p["g_c"] * np.cos(x))
        loaded = 1.0 + (p["mu"] * abs(p["load"]) + p["mu_g"] * weight) / p["F_c"]
        side = p["asymmetric"] * p["asymmetry"] * (-1.0 if v < 0.0 else 1.0)
        wave = np.sin(2 * np.pi * x / p["position_period"])
        along = p["position_dependent"] * p["position_amplitude"] * wave
        warm = p["drift"] * (1.0 - np.exp(-t / p["drift_time"]))
        return loaded * (1.0 + side) * (1.0 + along) * (1.0 - warm)

    def push(x: float) -> float:
        wave = p["ripple_amplitude"] * np.sin(2 * np.pi * x / p["ripple_period"])
        return float(p["ripple"] * wave - force_of_position(p, np.array([x]))[0])

    y, motor = [np.zeros(3)], [0.0]
    for begin, force in zip(t, target[:-1], strict=False):
        lack = motor[-1] - force

        def applied(s: float, x: float, force: float = force, lack: float = lack) -> float:
            return force + lack * np.exp(-s / lag) + push(x)

        y.append(hold(y[-1], p, applied, lambda s, x, v, t=begin: rough(t + s, x, v)))
        motor.append(force + lack * np.exp(-STEP / lag))
    x, v, z = np.transpose(y)
    there = [scaled(p, rough(*at)) for at in zip(t, x, v, strict=True)]
    F_f = np.array([friction(*at) for at in zip(v, z, there, strict=True)])
    x_enc = x + p["sde"] * np.sin(2 * np.pi * x / p["sde_period"])
    x_enc = np.rint(x_enc / p["encoder_step"]) * p["encoder_step"] if p["encoder"] else x_enc
    return {"time": t, "u": u, "x_enc": x_enc, "F_m": np.array(motor), "F_f": F_f, "x": x, "v": v}


def through_zero() -> tuple[np.ndarray, np.ndarray]:
    """Return times [s] and a velocity [m/s] that changes its sign."""
    t = np.arange(401) * STEP
    return t, 0.03 * np.sin(2 * np.pi * 6.0 * t) * np.cos(2 * np.pi * 1.5 * t) + 1e-4


def lugre(p: Parameters, speeds: np.ndarray | None = None) -> Columns:
    """Follow a velocity through zero, by z(t) = z_inf + (z - z_inf) e^(-a t).

    Of speeds that are given the lead and the viscous force are not taken again.
    """
    t, v = through_zero() if speeds is None else (np.arange(len(speeds)) * STEP, speeds)
    lead, b = (p["lead"], p["b"]) if speeds is None else (0.0, 0.0)
    slope = np.diff(v, prepend=v[0]) / STEP
    now = v + lead * slope
    held = now if speeds is not None or p["hold"] else now - slope * STEP / 2
    z, F_mean, F_f = 0.0, [0.0], [friction(v[0], 0.0, p) + b * v[0]]
    for speed, shown in zip(held[:-1], now[:-1], strict=True):
        end = np.sign(speed) * stribeck(speed, p) / p["sigma_0"]
        y = p["sigma_0"] * abs(speed) / stribeck(speed, p) * STEP
        way = -(end - z) * np.expm1(-y)
        mean_z = end - way / y
        F_mean.append(p["sigma_0"] * mean_z + damping(speed, p) * way / STEP + b * speed)
        z += way
        F_f.append(friction(shown, z, p) + b * shown)
    return {"time": t, "v": v, "F_f": np.array(F_f), "F_mean": np.array(F_mean)}


def dahl(p: Parameters) -> Columns:
    """Follow the same velocity: the force decays towards s F_c along the way (i = 1)."""
    t, v = through_zero()
    F_mean, F_d = [0.0], [0.0]
    for speed in v[:-1]:
        end, y = np.sign(speed) * p["F_c"], p["sigma_0"] * abs(speed) * STEP / p["F_c"]
        F_mean.append(end - (F_d[-1] - end) * np.expm1(-y) / y)
        F_d.append(end + (F_d[-1] - end) * np.exp(-y))
    return {"time": t, "v": v, "F_f": np.array(F_d), "F_mean": np.array(F_mean)}


def elasto_plastic(p: Parameters) -> Columns:
    """Follow the same velocity: scipy's DOP853 from the break-away deflection on."""
    t, v = through_zero()
    z, F_mean, F_f = 0.0, [0.0], [p["sigma_1"] * v[0]]

    def rate(speed: float, z: float) -> float:
        g, s = stribeck(speed, p), np.sign(speed)
        slack = p["z_ba"] * p["F_c"] / p["sigma_0"]
        share = np.clip((s * z - slack) / (g / p["sigma_0"] - slack), 0.0, 1.0)
        return speed * (1.0 - np.sin(np.pi / 2 * share) ** 2 * p["sigma_0"] * s * z / g)

    for speed in v[:-1]:
        s = np.sign(speed)
        slack = p["z_ba"] * p["F_c"] / p["sigma_0"]
        elastic = min(STEP, max(0.0, (slack - s * z) / abs(speed)))
        area = elastic * (z + speed * elastic / 2)
        begin = z + speed * elastic

        def motion(_: float, y: np.ndarray, speed: float = speed) -> list[float]:
            return [rate(speed, y[0] * Z_UNIT) / Z_UNIT, y[0]]

        left = STEP - elastic
        tight = {"rtol": 1e-13, "atol": 1e-13}
        end = solve_ivp(motion, (0.0, left), [begin / Z_UNIT, 0.0], "DOP853", **tight).y[:, -1]
        area += end[1] * Z_UNIT
        way, z = end[0] * Z_UNIT - z, end[0] * Z_UNIT
        F_mean.append((p["sigma_0"] * area + p["sigma_1"] * way) / STEP)
        F_f.append(p["sigma_0"] * z + p["sigma_1"] * rate(speed, z))
    return {"time": t, "v": v, "F_f": np.array(F_f), "F_mean": np.array(F_mean)}


def leuven(p: Parameters) -> Columns:
    """Follow the same velocity (n_h = 1): exponentials from one switch of an element on."""
    t, v = through_zero()
    kappa = array(p, "kappa", 4)
    k = p["sigma_0"] * kappa / kappa.sum()
    limit = np.append(array(p, "W", 3) * p["F_c"] / k[:3], np.inf)
    q, F_mean, F_f = np.zeros(4), [0.0], [p["sigma_1"] * v[0]]
    for speed in v[:-1]:
        g, s, left, area, begin = stribeck(speed, p), np.sign(speed), STEP, 0.0, q[3]
        while left > 0.0:
            rate = speed * (1.0 - s * (k @ q) / g)
            ahead = limit - np.sign(rate) * q
            free = ahead > 0.0
            a = k @ free * abs(speed) / g
            with np.errstate(divide="ignore"):  # at rest nothing is reached
                reach = a * np.where(free, ahead, np.inf) / abs(rate)
            h = min(left, -np.log1p(-min(reach)) / a) if min(reach) < 1.0 else left
            dz = -np.expm1(-a * h) / a * rate
            area += h * (k @ q) + (k @ free) * (h * rate - dz) / a
            q = np.where(free, q + dz, q)
            if h < left:
                q[np.argmin(reach)] = np.sign(rate) * limit[np.argmin(reach)]
            left -= h
        F_mean.append((area + p["sigma_1"] * (q[3] - begin)) / STEP)
        F_f.append(k @ q + p["sigma_1"] * speed * (1.0 - s * (k @ q) / g))
    return {"time": t, "v": v, "F_f": np.array(F_f), "F_mean": np.array(F_mean)}


def gms(p: Parameters) -> Columns:
    """Follow the same velocity, all elements at once: stick until the limit, then decay."""
    t, v = through_zero()
    alpha, kappa = array(p, "alpha", 4), array(p, "kappa", 4)
    alpha, k = alpha / alpha.sum(), p["sigma_0"] * kappa / kappa.sum()
    F, slips = np.zeros(4), np.zeros(4)
    F_mean, F_f = [0.0], [p["sigma_1"] * v[0]]
    for speed in v[:-1]:
        s, g = np.sign(speed), stribeck(speed, p)
        limit = s * alpha * g
        reach = np.clip((limit - F) / (k * speed), 0.0, STEP)
        sticking = np.where(slips == s, 0.0, reach)
        stuck = F + k * speed * sticking
        fade = np.exp(-p["C"] * (STEP - sticking) / g)
        end = limit + (stuck - limit) * fade
        area = sticking * (F + stuck) / 2 + limit * (STEP - sticking)
        area += (stuck - limit) * (1.0 - fade) * g / p["C"]
        damped = p["sigma_1"] / p["sigma_0"] * (end - F).sum() / STEP
        F_mean.append(area.sum() / STEP + damped)
        F, slips = end, np.where(sticking < STEP, s, 0.0)
        rate = np.where(slips == s, p["C"] * (limit - F) / g, k * speed)
        F_f.append(F.sum() + p["sigma_1"] / p["sigma_0"] * rate.sum())
    return {"time": t, "v": v, "F_f": np.array(F_f), "F_mean": np.array(F_mean)}


def coulomb_stribeck(p: Parameters) -> Columns:
    """Follow the same velocity along the curve."""
    t, v = through_zero()
    force = np.sign(v) * stribeck(v, p)
    now = np.append(force[0], force[:-1])  # of the velocity that was held over the step
    return {"time": t, "v": v, "F_f": now, "F_mean": np.append(0.0, force[:-1])}


def armstrong(p: Parameters) -> Columns:
    """Follow the same velocity: break-away by brentq, the delay from the displacement."""
    t, v = through_zero()
    interval = p["tau_L"] / 32
    per_step = round(STEP / interval)
    path = np.append(0.0, np.cumsum(v[:-1])) * STEP
    now = np.arange(per_step * 400 + 1) * interval
    past = np.append(np.zeros(32), np.diff(np.interp(now, t, path)) / interval)
    weight = 1.0 / (1.0 + (past / p["v_s"]) ** 2)  # over the interval from now[k] on
    d, mode, rest, share = 0.0, 0.0, 0.0, 0.0
    F_mean, F_f = [0.0], [p["sigma_t"] * v[0]]

    def sliding(share: float) -> float:
        return p["F_c"] + share * (p["F_s"] - p["F_c"])

    def risen(time: float) -> float:
        rested = rest + time
        return share + (1.0 - share) * rested / (rested + p["gamma"]) if p["gamma"] else 1.0

    for k, speed in enumerate(v[:-1]):
        s, begin, weights = np.sign(speed), 0.0, weight[per_step * k :][:per_step]
        area = 0.0
        if mode not in (0.0, s):
            share, rest = share * weights[0], 0.0
            d, mode = mode * sliding(share) / p["k_t"], 0.0
        if mode == 0.0:

            def lack(time: float, d: float = d, speed: float = speed, s: float = s) -> float:
                return sliding(risen(time)) - s * p["k_t"] * (d + speed * time)

            begin = brentq(lack, 0.0, STEP, xtol=1e-18) if lack(STEP) < 0.0 else STEP
            area = begin * (p["k_t"] * (d + speed * begin / 2) + p["sigma_t"] * speed)
            mode, share = (s, risen(begin)) if begin < STEP else (0.0, share)
            d, rest = d + speed * begin, rest + begin
        slid = np.diff(np.maximum(np.arange(per_step + 1) * interval, begin))
        F_mean.append((area + mode * slid @ sliding(share * weights)) / STEP)
        after = mode * sliding(share * weight[per_step * (k + 1)])
        F_f.append(after if mode else p["k_t"] * d + p["sigma_t"] * speed)
    # Forces between steps are those at the velocity that was held
    return {"time": t, "v": v, "F_f": np.array(F_f), "F_mean": np.array(F_mean)}


def controlled(p: Parameters, inputs: Columns) -> np.ndarray:
    """Return u, v_est, I, J (n, 4) after each sample of the controller's inputs (n,)."""
    keep = np.exp(-p["T_s"] / p["tau_f"]) if p["tau_f"] > 0 else 0.0
    v_est, integrals, x_last, rows = 0.0, np.zeros(2), inputs["x_enc"][0], []
    for v_cmd, a_cmd, x, F_ff, x_cmd, v_hat in zip(*inputs.values(), strict=True):
        v_est = keep * v_est + (1 - keep) * (x - x_last) / p["T_s"]
        x_last, e_x = x, x_cmd - x
        e_v = (
            p["velocity_feedforward"] * v_cmd
            + p["K_x"] * e_x
            - (v_hat if p["use_v_hat"] else v_est)
        )
        trial = integrals + p["T_s"] * np.array([p["K_i"] * e_v, p["I_x"] * e_x])
        demand = p["K_p"] * e_v + p["P_x"] * e_x + trial.sum() + F_ff + p["m_ff"] * a_cmd
        u = np.clip(demand, -p["u_max"], p["u_max"])
        free = (u == demand) | (np.sign(demand) != np.sign([e_v, e_x]))
        integrals = np.where(free, trial, integrals)
        rows.append((u, v_est, *integrals))
    return np.array(rows)


def velocity_controller(p: Parameters) -> Columns:
    """Follow a sine with an encoder that lags behind it; the force runs into its limit."""
    t = np.arange(201) * STEP
    v_cmd = 0.03 * np.sin(2 * np.pi * 20.0 * t) + np.where((t > 0.06) & (t < 0.07), 0.05, 0.0)
    inputs = {
        "v_cmd": v_cmd,
        "a_cmd": np.gradient(v_cmd, STEP),
        "x_enc": np.rint(2e-4 * (1.0 - np.cos(2 * np.pi * 20.0 * t - 0.2)) / 4e-7) * 4e-7,
        "F_ff": 6.0 * np.sign(v_cmd),
        "x_cmd": 2e-4 * (1.0 - np.cos(2 * np.pi * 20.0 * t)),
        "v_hat": v_cmd,
    }  # the last two have no effect where the switch is off and the gains of position are 0
    u, v_est, *_ = controlled(p, {name: values[:-1] for name, values in inputs.items()}).T
    return {"time": t, **inputs, "u": np.append(0.0, u), "v_est": np.append(0.0, v_est)}


def lagging_motion(p: Parameters) -> Columns:
    """Return a motion under a lagging force, of which known friction takes a part late."""
    p = start_values("velocity_filter") | p
    lag = p["tau_i"] or INSTANT
    t = np.arange(201) * STEP
    u = 40.0 * np.sin(2 * np.pi * 14.0 * t) + np.where(t > 0.05, 8.0, 0.0)
    F_ff = 6.0 * np.sign(np.sin(2 * np.pi * 14.0 * t - 0.4))
    rates = np.zeros((6, 6))  # x, v, and what changes it: motor force, known friction, u, F_ff
    rates[0, 1] = 1.0
    rates[1, 1:4] = np.array([-p["b"], 1.0, -1.0]) / p["m"]
    rates[2, [2, 4]] = rates[3, [3, 5]] = -1.0 / lag, 1.0 / lag
    rates[1, 5] = -0.1 / p["m"]
    move = expm(rates * STEP)
    state = [np.zeros(6)]
    for force, known in zip(u[:-1], F_ff[:-1], strict=True):
        state.append(move @ [*state[-1][:4], force, known])
    x, _, F_m, F_known, *_ = np.transpose(state)
    x_enc = np.rint(x / 4e-7) * 4e-7
    return {"time": t, "x_enc": x_enc, "F_m": F_m + p["F_0"], "F_in": F_ff, "N": F_m - F_known}


def predictor(p: Parameters, N: np.ndarray) -> Callable[[int, np.ndarray], np.ndarray]:
    """Return a function: sample and estimate (x, v, d) at the one before -> prediction.

    Between samples the net force N is what lags on from one sample's to the next: solve for the
    command that leads there, then predict with the same exponential.
    """
    rates = np.zeros((5, 5))  # x, v, d, N, u
    rates[0, 1] = 1.0
    rates[1, 1:4] = np.array([-p["b"], 1.0, 1.0]) / p["m"]
    lag = p["tau_i"] or INSTANT
    rates[3, 3:] = -1.0 / lag, 1.0 / lag
    move = expm(rates * STEP)
    held = (N[1:] - move[3, 3] * N[:-1]) / move[3, 4]

    def predicted(k: int, estimate: np.ndarray) -> np.ndarray:
        begin = [*estimate, N[k - 1], held[k - 1]] if k else [*estimate, 0.0, 0.0]
        return (move @ begin)[:3]

    return predicted


def velocity_filter(p: Parameters) -> Columns:
    """Estimate a motion under a lagging force; friction is known but for a tenth of it."""
    given = lagging_motion(p)
    predicted, gain = predictor(p, given.pop("N")), np.array([p["L_x"], p["L_v"], p["L_d"]])
    estimate, rate = [np.zeros(3)], 0.0
    for k, position in enumerate(given["x_enc"][:-1]):
        x, *others = predicted(k, estimate[-1])
        rate += p.get("L_1", 0.0) * (position - x)
        estimate.append([x, *others] + gain * (position - x) + [0.0, 0.0, STEP * rate])
    _, v_hat, d_hat = np.transpose(estimate)
    given["F_ff"] = given.pop("F_in")
    return {**given, "v_hat": v_hat, "d_hat": d_hat}


def reversing(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """Return a reference velocity that reverses and creeps, and the share of the force from it.

    The share is that of displacements from one to two times the onset since rest or reversal.
    """
    v_r, onset = 2e-3 * np.sin(2 * np.pi * 20.0 * t), p["onset"]
    if not onset:
        return v_r, np.ones(len(t))
    runs = np.cumsum(np.diff(np.where(abs(v_r) < onset, 0.0, np.sign(v_r)), prepend=0.0) != 0.0)
    way = pd.Series(STEP * np.where(abs(v_r) < onset, 0.0, abs(v_r))).groupby(runs).cumsum()
    return v_r, np.interp(way, [onset, 2 * onset], [0.0, 1.0])


def coulomb_observer(p: Parameters) -> Columns:
    """Observe the same, with a reference velocity that reverses and creeps."""
    given = lagging_motion(p)
    N = given.pop("N")
    predicted, (v_r, share) = predictor(p, N), reversing(given["time"], p)
    now, a, s, mean, leading = np.zeros(3), p["a_0"], 0.0, ahead(v_r, 0.0), ahead(v_r, p["lead"])
    F, a_hat = [0.0], [a]
    for k, position in enumerate(given["x_enc"][:-1]):
        x, v, _ = predicted(k, np.array([now[0], now[1], -a * s]))
        r = position - x
        now = np.array([x + p["L_x"] * r, v + p["L_v"] * r, 0.0])
        a -= s * p["L_d"] * r
        slope = (v_r[k] - v_r[max(k - 1, 0)]) / STEP
        v_s, v_lead = (now[1],) * 2 if p["measured"] else (mean[k], leading[k])
        s, early = np.clip(np.array([v_s, v_lead]) / p["v_t"], -1.0, 1.0)
        returned = p["k_a"] * (N[k] - a * s - p["b"] * now[1] - p["m"] * slope)
        F.append(given["F_in"][k] + share[k] * (p["share"] * a * early - returned))
        a_hat.append(a)
    return {**given, "v_r": v_r, "F": np.array(F), "a_hat": np.array(a_hat)}


def momentum(p: Parameters) -> Callable[[np.ndarray, np.ndarray], tuple[float, float]]:
    """Return a function: the last two net forces and positions -> friction [N], velocity [m/s].

    The force is weighted by quadrature.
    """
    fade, weight = np.exp(-STEP / p["tau_i"]), 1.0 - np.exp(-STEP / p["tau_f"])
    before, v, force = 0.0, 0.0, 0.0

    def residual(N: np.ndarray, x: np.ndarray) -> tuple[float, float]:
        nonlocal before, v, force
        held = (N[1] - fade * N[0]) / (1.0 - fade)

        def net(s: float) -> float:
            return float(held + (N[0] - held) * np.exp(-s * STEP / p["tau_i"]))

        mean = before + quad(lambda s: (1.0 - s) * net(s), 0.0, 1.0, epsabs=1e-13)[0]
        before = quad(lambda s: s * net(s), 0.0, 1.0, epsabs=1e-13)[0]
        force += weight * (mean - force)
        last, v = v, v + weight * ((x[1] - x[0]) / STEP - v)
        middle = (last + v) / 2
        return force - p["b"] * middle - p["m"] * (v - last) / STEP, middle

    return residual


def momentum_observer(p: Parameters) -> Columns:
    """Observe the same by the change of momentum."""
    given, residual = lagging_motion(p), momentum(p)
    N, x, (v_r, share) = given.pop("N"), given["x_enc"], reversing(given["time"], p)
    a, F, a_hat, s, w, v_k = p["a_0"], [0.0], [p["a_0"]], 1.0, p["w_q"], 0.0
    early = ahead(v_r, p["lead"])
    for k in range(200):
        last = max(k - 1, 0)
        friction, v = residual(N[[last, k]], x[[last, k]])
        v_k = 2.0 * v - v_k
        if p["coulomb"]:
            s = np.clip(v / p["v_t"], -1.0, 1.0)
            w = p["w_q"] * (abs(v) / p["v_t"]) ** (p["mu"] - 1.0)
        a += (1.0 - np.exp(-w * STEP)) * s * (friction - a * s)
        side = np.clip((v_k if p["measured"] else early[k]) / p["v_t"], -1.0, 1.0)
        force = p["share"] * a * (side if p["coulomb"] else 1.0)
        F.append(given["F_in"][k] + share[k] * force)
        a_hat.append(a)
    return {**given, "v_r": v_r, "F": np.array(F), "a_hat": np.array(a_hat)}


def adaptive_scale(p: Parameters) -> Columns:
    """Scale known friction beside a reference that reverses; the axis moves in one direction."""
    given, residual = lagging_motion(p), momentum(p)
    given.pop("N")
    x, f, F_m = given["x_enc"], given["F_in"], given["F_m"] - p["F_0"]
    v_r = 0.05 * np.sin(2 * np.pi * 14.0 * given["time"] - 0.4) + 0.01
    share, fade = 1.0 - np.exp(-p["rate"] * STEP), np.exp(-STEP / p["tau_i"])
    s, square, known, sign, q, start = p["s_0"], 0.0, 0.0, 0.0, 0.0, 0.0
    s = np.clip(s, p["least"], p["most"])
    F, N = [0.0], [F_m[0]]
    for k in range(200):
        last = max(k - 1, 0)
        if k:
            known = F[-1] + (known - F[-1]) * fade
            N.append(F_m[k] - known)
        error, _ = residual(np.array([N[last], N[k]]), x[[last, k]])
        F.append(s * f[k])
        moves = sign * v_r[last] > p["v_min"] and q > p["q_min"]
        if k and moves and sign * (x[k] - start) > q / 2 and sign * f[last] > 0.0:
            square += share * (f[last] ** 2 - square) if square else f[last] ** 2
            s = np.clip(s + share * error * f[last] / square, p["least"], p["most"])
        mean = (v_r[k] + v_r[last]) / 2
        if np.sign(mean) != sign:
            sign, q, start = np.sign(mean), 0.0, x[k]
        q += abs(mean) * STEP
    return {**given, "v_r": v_r, "F": np.array(F)}


def coulomb_with_ramp(p: Parameters, v: np.ndarray) -> np.ndarray:
    """Return Coulomb friction with a ramp at velocities, and viscous friction."""
    side = 1.0 + p["asymmetry"] * np.where(v < 0.0, -1.0, 1.0)
    return side * p["F_c"] * np.clip(v / p["v_t"], -1.0, 1.0) + p["b"] * v


def static_feedforward(p: Parameters) -> Columns:
    """Follow a velocity through zero, with another compensator's force beside it."""
    t, v = through_zero()
    F_in = 2.0 * np.cos(2 * np.pi * 3.0 * t)
    force = coulomb_with_ramp(p, ahead(v[:-1], p["lead"]))
    return {"time": t, "v": v, "F_in": F_in, "F": np.append(0.0, F_in[:-1] + force)}


def force_of_position(p: Parameters, x: np.ndarray) -> np.ndarray:
    """Return the force of position at places (n,)."""
    turn, k = np.exp(1j * x), np.arange(1, 4)
    waves = np.exp(2j * np.pi * np.outer(x / p["pitch"], k))
    cogging = array(p, "cogging_c", 3) - 1j * array(p, "cogging_s", 3)
    return p["F_0"] + np.real((p["g_c"] - 1j * p["g_s"]) * turn + waves @ cogging)


def position_force(p: Parameters) -> Columns:
    """Go to and fro over several pitches, with another compensator's force beside it."""
    t, v = through_zero()
    x, F_in = 0.1 + 2.0 * np.cumsum(v) * STEP / 0.03, 2.0 * np.cos(2 * np.pi * 3.0 * t)
    weight = np.abs(p["g_s"] * np.sin(x) + p["g_c"] * np.cos(x))
    force = F_in * (1.0 + p["mu_g"] * weight / p["F_c"]) + force_of_position(p, x)
    return {"time": t, "x": x, "F_in": F_in, "F": np.append(force[0], force[:-1])}


def dob(p: Parameters) -> Columns:
    """Observe what velocity_filter does, with its known friction as another compensator's."""
    table = velocity_filter(p)
    known = table.pop("F_ff")
    table.pop("v_hat")
    v_r, share = reversing(table["time"], p)
    force = known[:-1] - share[:-1] * p["share"] * table["d_hat"][1:]
    return {**table, "v_r": v_r, "F_in": known, "F": np.append(0.0, force)}


def lugre_observer(p: Parameters, n: int = 401, held: tuple[float, float] | None = None) -> Columns:
    """Follow an encoder that lags behind a reference for n samples, with (2) by Radau.

    With ``held``, both have constant velocities [m/s].
    """
    t, v_r = (column[:n] for column in through_zero())
    x_enc = np.cumsum(np.concatenate([[0.0], v_r[:-2], [0.0]])) * STEP
    if held:
        x_enc, v_r = held[0] * t, np.full(len(t), held[1])
    x_enc = np.rint(x_enc / 4e-7) * 4e-7
    F_in = 2.0 * np.cos(2 * np.pi * 3.0 * t)
    weight = 1.0 - np.exp(-STEP / p["tau_f"]) if p["tau_f"] else 1.0
    v_k, z, F, z_hat, early = 0.0, 0.0, [0.0], [0.0], ahead(v_r, p["lead"])
    for k in range(n - 1):
        last = max(k - 1, 0)
        v_k += weight * ((x_enc[k] - x_enc[last]) / STEP - v_k)
        v, correction = early[k] if p["reference"] else v_k, p["k_e"] * (v_k - v_r[last])

        def motion(_: float, y: np.ndarray, v: float = v, c: float = correction) -> list[float]:
            dz = bristle_rate(v, y[0] * Z_UNIT, p) - c
            damped = dz + (1.0 - p["share_1"]) * c
            return [dz / Z_UNIT, y[0], damped / Z_UNIT]

        tight = {"rtol": 1e-11, "atol": 1e-14}
        solved = solve_ivp(motion, (0.0, STEP), [z / Z_UNIT, 0.0, 0.0], "Radau", **tight).y
        z, area, damped = solved[:, -1] * Z_UNIT
        z = np.clip(z, -3 * p["F_s"] / p["sigma_0"], 3 * p["F_s"] / p["sigma_0"])
        F.append(F_in[k] + (p["sigma_0"] * area + damping(v, p) * damped) / STEP)
        z_hat.append(z)
    return {"time": t, "x_enc": x_enc, "v_r": v_r, "F_in": F_in, "F": F, "z_hat": z_hat}


def learning_signals(p: Parameters) -> Columns:
    """Return a reference through zero and a controller that gives what it needs, and 5 N more."""
    t, v_r = through_zero()
    F_in = 2.0 * np.cos(2 * np.pi * 3.0 * t)
    u = 5.0 * np.sign(v_r) + p["m"] * np.gradient(v_r, STEP)
    return {"time": t, "v_r": v_r, "u": u, "F_in": F_in}


def explained(p: Parameters, v_r: np.ndarray) -> np.ndarray:
    """Return the force [N] of the periods before, which the motion explains."""
    last = np.append(v_r[0], v_r[:-1])
    return np.append(0.0, (p["m"] * (v_r - last) / STEP + p["b"] * (v_r + last) / 2)[:-1])


def network(
    p: Parameters, w: np.ndarray, force: Network, gradient: Network, limit: np.ndarray | float
) -> Columns:
    """Learn weights w, up to a limit, of force(w, v, way since the reversal) along gradient."""
    given, F, old = learning_signals(p), [0.0], []
    known, q, direction = explained(p, given["v_r"]), 0.0, 0.0
    for k, v in enumerate(ahead(given["v_r"], p["lead"])[:-1]):
        error = given["u"][k] - F[-1] - known[k]
        if np.sign(v) != direction:
            direction, q = np.sign(v), 0.0
        old.append((v, q + abs(v) * STEP / 2))
        q += abs(v) * STEP
        F.append(given["F_in"][k] + force(w, *old[-1]))
        if k >= p["D"]:
            by = gradient(w, *old[k - int(p["D"])])
            w = np.clip(w + p["gamma"] * error * by / (by**2).sum(), -limit, limit)
    return {**given, "F": np.array(F)}


def lffc(p: Parameters) -> Columns:
    """Learn with hats by linear interpolation of unit vectors over the knots."""
    knots = np.append(0.0, np.geomspace(p["first"], p["last"], 13))

    def hats(_: np.ndarray, v: float, q: float) -> np.ndarray:
        mu = np.zeros((2, 14))
        mu[int(v < 0.0)] = [np.interp(q, knots, unit) for unit in np.eye(14)]
        return mu

    def force(w: np.ndarray, *place: float) -> np.ndarray:
        return (w * hats(w, *place)).sum()

    return network(p, array(p, "w_0", 2, 14), force, hats, p["F_max"])


def inputs_of_network(p: Parameters, v: float, q: float) -> tuple[float, float]:
    """Return velocity and way, each from -1 to 1 with the sign of the velocity."""
    speed = np.log1p(abs(v) / p["v_0"]) / np.log1p(p["v_max"] / p["v_0"])
    return np.sign(v) * min(speed, 1.0), np.sign(v) * (q - p["q_0"]) / (q + p["q_0"])


def rbf(p: Parameters) -> Columns:
    """Learn with Gaussian functions whose shares are an outer product."""

    def shares(place: float, n: int) -> np.ndarray:
        centres = np.linspace(-1.0, 1.0, n)
        share = np.exp(-(((place - centres) / (p["width"] * 2.0 / (n - 1))) ** 2) / 2)
        return share / share.sum()

    def both(_: np.ndarray, *place: float) -> np.ndarray:
        y_v, y_q = inputs_of_network(p, *place)
        return np.outer(shares(y_v, 11), shares(y_q, 8))

    def force(w: np.ndarray, *place: float) -> np.ndarray:
        return (w * both(w, *place)).sum()

    return network(p, array(p, "w_0", 11, 8), force, both, p["F_max"])


def mlp(p: Parameters) -> Columns:
    """Learn with a hidden layer, whose gradient is from complex steps."""

    def force(w: np.ndarray, *place: float) -> np.ndarray:
        return p["F_max"] * np.tanh(w[:, :3] @ [*inputs_of_network(p, *place), 1.0]) @ w[:, 3]

    def gradient(w: np.ndarray, *place: float) -> np.ndarray:
        moved = (w + 1e-30j * one.reshape(8, 4) for one in np.eye(32))
        return np.reshape([force(each, *place).imag / 1e-30 for each in moved], (8, 4))

    return network(p, array(p, "w_0", 8, 4), force, gradient, np.array([20.0, 20.0, 20.0, 1.0]))


def lugre_network(p: Parameters) -> Columns:
    """Learn LuGre parameters by the gradient, with its derivatives from complex steps."""
    given, names = learning_signals(p), ("F_c", "sigma_0", "sigma_1", "F_s", "v_s")
    theta = {name: p[name] for name in names}
    tiny, z, z_by = 1e-30, 0.0, np.zeros(5)
    known, F, old = explained(p, given["v_r"]), [0.0], []

    def held(v: float, z: complex, theta: Mapping[str, complex]) -> tuple[complex, complex]:
        """Return the mean force and the deflection at the end, at v != 0."""
        own = {**theta, "delta": p["delta"]}
        end = np.sign(v) * stribeck(v, own) / own["sigma_0"]
        y = own["sigma_0"] * abs(v) / stribeck(v, own) * STEP
        way = -(end - z) * np.expm1(-y)
        return own["sigma_0"] * (end - way / y) + own["sigma_1"] * way / STEP, z + way

    for k, v in enumerate(ahead(given["v_r"], p["lead"])[:-1]):
        error = given["u"][k] - F[-1] - known[k]
        by = np.zeros(5)
        for i, name in enumerate(names):
            moved = {**theta, name: theta[name] * (1.0 + 1j * tiny)}
            force, end = held(v, z + 1j * tiny * z_by[i], moved)
            by[i], z_by[i] = force.imag / tiny, end.imag / tiny
        force, z = held(v, z, theta)
        F.append(given["F_in"][k] + force)
        old.append(by)
        if k >= p["D"]:
            gradient = old[k - int(p["D"])]
            factor = p["gamma"] * error * gradient / ((gradient**2).sum() + 0.01)
            for name, change in zip(names, np.clip(factor, -0.02, 0.02), strict=True):
                theta[name] *= np.exp(change)
            theta["F_s"] = max(theta["F_s"], theta["F_c"])
    return {**given, "F": np.array(F)}


def nominal_loop(p: Parameters) -> Columns:
    """Follow a step and a sine."""
    t = np.arange(101) * STEP
    v_cmd = np.where(t < 0.02, 0.02, 0.03 * np.sin(2 * np.pi * 60.0 * t))
    A, B, C = array(p, "A", 8, 8), array(p, "B", 8), array(p, "C", 8)
    a_cmd = np.gradient(v_cmd, STEP)  # without effect, for E starts at 0
    x, v_r = np.zeros(8), [0.0]
    for command in v_cmd[:-1]:
        x = A @ x + B * command
        v_r.append(C @ x + p["D"] * command)
    return {"time": t, "v_cmd": v_cmd, "a_cmd": a_cmd, "v_r": np.array(v_r)}


def commands(p: Parameters) -> tuple[Columns, np.ndarray]:
    """Return commands and v_r of the loop without friction, and its mean velocities, ahead."""
    t, v_cmd = (column[:201] for column in through_zero())
    commands = {"v_cmd": v_cmd, "x_cmd": 0.01 + np.cumsum(v_cmd) * STEP}
    commands["a_cmd"] = np.gradient(v_cmd, STEP)
    A, (B, G, E, C) = array(p, "loop_A", 8, 8), (array(p, f"loop_{name}", 8) for name in "BGEC")
    x, x_last, v_r = np.zeros(8), commands["x_cmd"][0], [0.0]
    for v, place, a in zip(*commands.values(), strict=True):
        x, x_last = A @ (x + G * (place - x_last)) + B * v + E * a, place
        v_r.append(C @ x + p["loop_D"] * v)
    early = ahead(np.array([p["loop_D"] * v_cmd[0], *v_r[1:]]), p["lead"])[1:]
    return {"time": t, **commands, "v_r": np.array(v_r[:-1])}, early


def command_feedforward(p: Parameters) -> Columns:
    """Follow the loop without friction by the closed form of LuGre."""
    given, v = commands(p)
    return {**given, "F_ff": lugre(p, v)["F_mean"] + p["b"] * np.append(0.0, v[:-1])}


def command_static(p: Parameters) -> Columns:
    """Follow it by Coulomb friction with a ramp."""
    given, v = commands(p)
    return {**given, "F_ff": np.append(0.0, coulomb_with_ramp(p, v)[:-1])}


def main(names: list[str]) -> None:
    """Write the reference.csv of the laws and models that are named, or of all."""
    every = (*models.law_names(), *models.model_names())
    for name in names or [one for one in every if one in globals()]:
        if name not in every or name not in globals():
            raise SystemExit(
                f"{name}: expected a law or model with a function {name} in {__file__}"
            )
        table = pd.DataFrame(globals()[name](start_values(name)))
        text = table.to_csv(index=False, float_format="%.15g", lineterminator="\n")
        path = reference_file(model_of(name))
        atomic_write(path, text)


if __name__ == "__main__":
    main(sys.argv[1:])
