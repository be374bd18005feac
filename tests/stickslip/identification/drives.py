"""Drives whose friction is not LuGre's, recorded by a program that shares nothing with ours."""

import ctypes
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from stickslip.fmi import toolchain

LAWS = ("lugre", "dahl", "gms", "elasto_plastic", "ideal_stiction")
T_S = 5e-4
GAINS = {"K_p": 1681.0, "K_i": 137167.0, "tau_f": 5e-4, "T_s": T_S}
STAGE = {
    "m": 5.557,
    "b": 6.6135,
    "F_s": 8.999,
    "F_c": 5.999,
    "v_s": 5.5697e-4,
    "sigma_0": 3.9162e5,
    "sigma_1": 4424.8,
    "uneven": 0.08,  # share by which friction varies with the position
    "period": 0.02,  # of that variation [m]
    **GAINS,
    "encoder": 4e-7,
    "u_max": 1e9,
    "integral": 0.0,
}
_Doubles = ctypes.POINTER(ctypes.c_double)


class _Drive(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_double)
        for name in (
            *("m", "b", "F_s", "F_c", "v_s", "sigma_0", "sigma_1", "uneven", "period"),
            *("K_p", "K_i", "tau_f", "T_s", "encoder", "u_max", "integral"),
        )
    ]


@cache
def _library():
    source = (Path(__file__).parent / "drives.c").read_text()
    return ctypes.CDLL(str(toolchain.shared_library("drives", {"drives.c": source})))


def run(law, v_cmd, feedforward=None, **changes):
    """Return time, position, commanded and applied force, velocity and command, (n,) each.

    GMS has the damping of its elements in sigma_1, which is 1000 N s/m by default.
    """
    values = {**STAGE, **({"sigma_1": 1000.0} if law == "gms" else {}), **changes}
    v_cmd = np.ascontiguousarray(v_cmd, dtype=float)
    columns = {name: np.empty(len(v_cmd)) for name in ("position", "commanded", "applied", "v")}
    ff = None if feedforward is None else np.ascontiguousarray(feedforward, dtype=float)
    pointers = [None if a is None else a.ctypes.data_as(_Doubles) for a in (v_cmd, ff)]
    _library().record(
        LAWS.index(law),
        ctypes.byref(_Drive(**values)),
        len(v_cmd),
        *pointers,
        10,
        *(column.ctypes.data_as(_Doubles) for column in columns.values()),
    )
    return {"t": np.arange(len(v_cmd)) * values["T_s"], **columns, "v_cmd": v_cmd}


def write_log(path, recorded, force=None):
    """Write a log in SI units; the force is the applied one unless another is given."""
    table = {
        "time [s]": recorded["t"],
        "position [m]": recorded["position"],
        "force [N]": recorded["applied"] if force is None else force,
        "velocity_command [m/s]": recorded["v_cmd"],
    }
    pd.DataFrame(table).to_csv(path, index=False, float_format="%.12g")
    return path
