"""Drives whose friction is not LuGre's, recorded by a program that shares nothing with ours."""

import numpy as np
import pandas as pd

from campaigns.sound_drives import simulator
from stickslip.logs import Recording

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
}


def run(law, v_cmd, feedforward=None, **changes):
    """Return time, position, commanded and applied force, velocity and command, (n,) each.

    GMS has the damping of its elements in sigma_1, which is 1000 N s/m by default.
    """
    values = {**STAGE, **({"sigma_1": 1000.0} if law == "gms" else {}), **changes}
    found = simulator.run(law, values, v_cmd, F_ff=feedforward)
    renamed = {"position": "encoder", "commanded": "commanded", "applied": "force", "v": "v"}
    columns = {name: found[column] for name, column in renamed.items()}
    return {"t": np.arange(len(v_cmd)) * values["T_s"], **columns, "v_cmd": v_cmd}


def recording(law, v_cmd, noise=0.0, source="log", feedforward=None, **changes):
    """Return a recording of a run on an even guide, with noise [N] on its force."""
    values = {"uneven": 0.0, "encoder": STAGE["encoder"], **changes}
    shown = run(law, v_cmd, feedforward, **values)
    force = shown["applied"] + noise * np.random.default_rng(0).standard_normal(len(v_cmd))
    known = {"velocity_command": v_cmd, "encoder_step": values["encoder"], "source": source}
    return Recording(shown["t"], shown["position"], force, **known)


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
