"""Compensators beside each other in one velocity loop.

    python examples/compare_compensators.py

Prints the velocity error in the 0.1 s after the reversal of a trapezoid, with friction as the
compensators assume it and with half of it, and the peak sensitivity of the loop. Replace DRIVE by
the values of your drive, or add a compensator to CHAINS: a model of models/compensators with its
parameters, alone or behind another.
"""

import tempfile

import numpy as np

import stickslip as ss

DRIVE = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4.4248e3}
ENCODER = 4e-7  # m
FOLDER = tempfile.mkdtemp(prefix="compare_compensators_")  # of the FMUs
COMMAND = ss.Trapezoid(height=0.040, slope=0.055, plateau=0.2, begin=0.1)  # m/s, m/s2, s, s
REVERSAL = 0.1 + 2 * 0.040 / 0.055 + 0.2  # s

axis = ss.Axis(m=5.557, b=6.6135, tau_i=1e-4)  # kg, N s/m, s
design = ss.LoopSpecification(
    bandwidth=125.0, phase_margin=50.0, T_s=5e-4, tau_f=5e-4
)  # Hz, deg, s
loop = ss.design_velocity_loop(axis, design)
observer = ss.design_observer(loop, encoder_step=ENCODER, friction=DRIVE["F_c"]).observer

static = ss.Compensator("static", "static_feedforward", {"F_c": DRIVE["F_c"], "v_t": 5e-4})
lugre = ss.Compensator("lugre", "compensator", DRIVE, law="lugre")
dob = ss.Compensator("observer", "dob", observer.parameters())
CHAINS = {
    "none": [],
    "static": [static],
    "LuGre": [lugre],
    "observer": [dob],
    "LuGre, then observer": [lugre, dob],
}


def error(chain: list[ss.Compensator], share: float) -> float:
    """Return the RMS velocity error [mm/s] after the reversal, with a share of the friction."""
    system = ss.closed_loop(loop, chain, folder=FOLDER, drive={"encoder_step": ENCODER})
    friction = {f"drive.{n}": value * (share if n != "v_s" else 1.0) for n, value in DRIVE.items()}
    signals = {"v_cmd": COMMAND}
    run = ss.simulate(system, stop=1.9, step=loop.T_s, parameters=friction, inputs=signals)
    after = (run.time > REVERSAL) & (run.time < REVERSAL + 0.1)
    return 1e3 * float(np.sqrt(np.mean((run["drive.v"] - run["nominal.v_r"])[after] ** 2)))


print(f"{'RMS error [mm/s]':22}{'as assumed':>12}{'half':>12}{'Ms':>8}")
for name, chain in CHAINS.items():
    peak = ss.robustness(loop, chain, friction=DRIVE["F_c"], folder=FOLDER).peak
    print(f"{name:22}{error(chain, 1.0):12.3f}{error(chain, 0.5):12.3f}{peak:8.2f}")
