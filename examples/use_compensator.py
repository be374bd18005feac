"""The tuned compensator, exported and used in other tools.

    python examples/use_compensator.py [FOLDER]

Builds compensator.fmu with learned start values and runs it twice on the same velocity: alone in
FMPy, as any other tool would, and in a cosim system. The forces are the same bit for bit. Without
a folder it writes into a temporary one.
"""

import json
import sys
import tempfile
from pathlib import Path

import fmpy
import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from stickslip import cosim, models

matplotlib.use("Agg")  # draw into files, on machines without a screen too
LEARNED = Path(__file__).parent.parent / "results" / "paper" / "learned.json"
TABLE_2 = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4.4248e3}
STEP, STOP = 5e-4, 1.0  # s

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="use_compensator_"))

# 1. The parameters: those that `stickslip reproduce` learned.
if LEARNED.is_file():
    entries = json.loads(LEARNED.read_text(encoding="utf-8"))["parameters"]
    values = {name: entry["value"] for name, entry in entries.items()}
    print(f"parameters: learned, from {LEARNED.relative_to(LEARNED.parents[2])}")
else:
    values = TABLE_2
    print("parameters: identified ones of the paper's Table 2, because nothing is learned yet")
print(", ".join(f"{name} = {value:.5g}" for name, value in values.items()) + " (SI units)")

# 2. The FMU, with these as its start values: it needs no further settings.
fmu = models.build_fmu("compensator", folder, start=values)

# 3. A velocity command: first forward and back within the presliding range, then sliding.
time = STEP * np.arange(round(STOP / STEP) + 1)  # s
velocity = np.where(time < 0.5, 1e-4, 4e-3) * np.sin(2 * np.pi * 4 * time)  # m/s
displacement = STEP * np.cumsum(velocity)  # m

# 4. Alone in FMPy. Inputs are a structured array: time first, then a column per input.
table = np.array(list(zip(time, velocity, strict=True)), dtype=[("time", "f8"), ("v", "f8")])
times = {"stop_time": STOP, "step_size": STEP, "output_interval": STEP}
alone = fmpy.simulate_fmu(str(fmu), **times, input=table, output=["F_f", "F_mean"])

# 5. In a system of FMUs, where F_mean is connected to the feedforward input of a controller.
system = cosim.System("feedforward")
system.add("compensator", fmu)
system.expose("v", "compensator.v")
with system.prepare(step=STEP, stop=STOP) as simulation:
    coupled = simulation.run(inputs={"v": velocity})

names = ("F_f", "F_mean")
same = all(np.array_equal(alone[name], coupled[f"compensator.{name}"]) for name in names)
print(f"FMPy and cosim give the same force bit for bit: {'yes' if same else 'NO'}")
force = coupled["compensator.F_f"]  # N
presliding, sliding = time < 0.5, time >= 0.75  # one period later the beginning is forgotten
peaks = force[presliding].max(), force[sliding].max()
print(f"largest force {peaks[0]:.3f} N within presliding, {peaks[1]:.3f} N when it breaks away")

v = np.linspace(-4e-3, 4e-3, 1000)  # m/s
stribeck = values["F_c"] + (values["F_s"] - values["F_c"]) * np.exp(-np.abs(v) / values["v_s"])
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
left.plot(1e3 * v, np.sign(v) * stribeck, "k--", linewidth=1, label="steady")
left.plot(1e3 * velocity[sliding], force[sliding], label="4 Hz, 4 mm/s")
left.set(xlabel="velocity [mm/s]", title="Sliding: the Stribeck curve, with hysteresis")
right.plot(
    1e6 * displacement[presliding], force[presliding], color="tab:orange", label="4 Hz, 0.1 mm/s"
)
right.set(xlabel="displacement [µm]", title="Presliding: bristles bend as a spring")
for axes in (left, right):
    axes.set_ylabel("friction force [N]")
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left", fontsize="small")
figure.savefig(folder / "use_compensator.png", dpi=150)
print(f"written: {folder / 'use_compensator.png'} and {fmu.name} in the same folder")
