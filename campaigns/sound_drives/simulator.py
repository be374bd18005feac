"""Runs a drive of ``simulator.c``, which shares nothing with the product but the compiler."""

import ctypes
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np

from stickslip.fmi.toolchain import shared_library

LAWS = ("none", "lugre", "dahl", "gms", "elasto_plastic", "coulomb_stribeck")
PARAMETERS = (
    *("m", "b", "F_c", "F_s", "v_s", "delta", "sigma_0", "sigma_1"),
    *("asymmetry", "uneven", "period", "origin"),
    *("F_0", "g_s", "g_c", "mu_g", "pitch", "s_1", "c_1", "s_2", "c_2", "motor", "held"),
    *("K_p", "K_i", "K_x", "velocity_feedforward", "tau_f", "T_s"),
    *("u_min", "u_max", "encoder", "phase", "z_ba"),
)
DEFAULTS = {
    "delta": 1.0, "period": 1.0, "pitch": 1.0, "velocity_feedforward": 1.0, "u_min": -math.inf,
    "u_max": math.inf, "z_ba": 0.7,
}  # fmt: skip
SUBSTEP = 5e-5  # [s]
_Doubles = ctypes.POINTER(ctypes.c_double)


class _Drive(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double) for name in PARAMETERS]


@cache
def _simulator() -> ctypes.CDLL:
    """Return the library of ``simulator.c``."""
    source = Path(__file__).with_name("simulator.c").read_text(encoding="utf-8")
    return ctypes.CDLL(str(shared_library("simulator", {"simulator.c": source}, flags=["-lm"])))


def positions(v_cmd: np.ndarray, T_s: float) -> np.ndarray:
    """Return the position command [m] of velocities (n,) [m/s]."""
    return T_s * np.concatenate([[0.0], np.cumsum(0.5 * (v_cmd[1:] + v_cmd[:-1]))])


def run(
    law: str,
    parameters: Mapping[str, float],
    v_cmd: np.ndarray,
    *,
    x_cmd: np.ndarray | None = None,
    F_ff: np.ndarray | None = None,
    noise: tuple[float, float] = (0.0, 0.0),
    seed: int = 0,
    compensator: ctypes.CDLL | None = None,
) -> dict[str, np.ndarray]:
    """Run a drive along a command.

    Parameters
    ----------
    parameters : by name, see ``PARAMETERS``; for a rotary drive read rad for m
    v_cmd, x_cmd, F_ff : velocities [m/s], positions [m] and feedforward forces [N], (n,) each
    noise : standard deviations of the encoder [steps] and of the measured force [N]
    compensator : a library with the functions ``begin`` and ``added`` of ``simulator.c``

    Returns
    -------
    dict
        (n,) each: encoder [m], commanded and measured force [N], true v [m/s] and x [m]
    """
    T_s, n = parameters["T_s"], len(v_cmd)
    rng = np.random.default_rng(seed)
    inputs = [v_cmd, positions(v_cmd, T_s) if x_cmd is None else x_cmd, F_ff]
    inputs += [deviation * rng.standard_normal(n) for deviation in noise]
    arrays = [None if one is None else np.ascontiguousarray(one, dtype=float) for one in inputs]
    columns = {name: np.empty(n) for name in ("encoder", "commanded", "force", "v", "x")}
    _simulator().record(
        LAWS.index(law),
        ctypes.byref(_Drive(**{**DEFAULTS, **parameters})),
        n,
        *(None if one is None else one.ctypes.data_as(_Doubles) for one in arrays),
        compensator and compensator.begin,
        compensator and compensator.added,
        max(2, round(T_s / SUBSTEP)),
        *(column.ctypes.data_as(_Doubles) for column in columns.values()),
    )
    return columns
