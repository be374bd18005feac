"""A closed loop of FMUs, run from Python.

    python examples/closed_loop.py [FOLDER]

Builds a velocity controller and a servo drive with friction, closes the loop, runs a trapezoid
and a sine sweep through it, and writes a table, a picture and loop.ssp, which other tools open.
Without a folder it writes into a temporary one.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from stickslip import cosim, models

matplotlib.use("Agg")  # draw into files, on machines without a screen too
folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="closed_loop_"))

# 1. The FMUs. These are part of stickslip; any other FMU (FMI 2.0 or 3.0) can be used.
controller = models.build_fmu("velocity_controller", folder)
drive = models.build_fmu("drive", folder)

# 2. The connections. Names are component.variable; a wrong name or unit is refused with a reason.
system = cosim.System("loop")
system.add("controller", controller, parameters={"K_p": 4717.0, "K_i": 68475.0})  # N s/m, N/m
system.add("drive", drive, parameters={"m": 5.557, "F_c": 6.0})  # kg, N
system.connect("controller.u", "drive.u")
system.connect("drive.x_enc", "controller.x_enc")
system.expose("v_cmd", "controller.v_cmd")  # an input of the whole system

# 3. Run. The FMUs are loaded once; each run resets them and has its own inputs and parameters.
trapezoid = cosim.Trapezoid(height=0.040, slope=0.2, plateau=0.3, begin=0.1)  # m/s, m/s2, s, s
sweep = cosim.SineSweep(frequency=(0.5, 5.0), amplitude=(0.03, 0.04), duration=2.0)  # Hz, m/s, s
with system.prepare(step=5e-4, stop=2.0) as simulation:  # s
    print(f"components step in the order {' -> '.join(simulation.order)}")
    result = simulation.run(inputs={"v_cmd": trapezoid})
    slippery = simulation.run(inputs={"v_cmd": trapezoid}, parameters={"drive.F_c": 1.0})
    swept = simulation.run(inputs={"v_cmd": sweep})

# 4. Results: arrays by name, or one DataFrame with the time as index and units in its attrs. (The
# ripple of the controller's force is the encoder's resolution of 0.4 um, times K_p.)
for label, run in (("trapezoid", result), ("with F_c = 1 N", slippery), ("sine sweep", swept)):
    worst = np.abs(run["v_cmd"] - run["drive.v"]).max()
    print(f"{label:15} largest velocity error {1e3 * worst:.3f} mm/s")
frame = result.frame()
print(frame[["v_cmd", "drive.v", "drive.F_f"]].describe().loc[["min", "max"]])
print("units:", ", ".join(f"{name} [{unit}]" for name, unit in frame.attrs["units"].items()))

figure, (above, below) = plt.subplots(2, sharex=True, figsize=(7, 5), layout="constrained")
above.plot(frame.index, 1e3 * frame["drive.v"], linewidth=2, label="drive")
above.plot(frame.index, 1e3 * frame["v_cmd"], "k--", linewidth=1, label="command")
above.set_ylabel("velocity [mm/s]")
below.plot(frame.index, frame["controller.u"], color="tab:gray", linewidth=0.4, label="controller")
below.plot(frame.index, frame["drive.F_f"], color="tab:red", label="friction")
below.set(xlabel="time [s]", ylabel="force [N]")
for axes in (above, below):
    axes.grid(alpha=0.3)
    axes.legend(loc="upper right")
figure.savefig(folder / "closed_loop.png", dpi=150)

# 5. Keep: the samples as CSV, the system with its FMUs and parameters as an SSP package.
result.to_csv(folder / "closed_loop.csv")
cosim.write_ssp(system, folder / "loop.ssp", cosim.DefaultExperiment(0.0, 2.0, 5e-4))
print(f"written: {folder / 'closed_loop.png'}, closed_loop.csv and loop.ssp in the same folder")
