"""Parameters of an FMU learned against a target signal.

    python examples/learn_parameters.py [FOLDER]

The target is the motion of a stage whose friction is known; in your case it is a recording. The
genetic algorithm searches the parameters with which the FMU repeats that motion. To use it for
another FMU, change the names, the ranges and the cost. Without a folder it writes into a
temporary one.
"""

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from stickslip import cosim, ga, models

matplotlib.use("Agg")  # draw into files, on machines without a screen too
TRUE = {"stage.F_c": 4.2, "stage.sigma_0": 2.5e5}  # N, N/m: what is to be found


@dataclass(frozen=True)
class PositionError:
    """Root mean square of the distance to a recorded position (n,) [m]."""

    target: np.ndarray

    def __call__(self, result: cosim.Result) -> float:
        """Return the cost of one run, not negative [m]."""
        return float(np.sqrt(np.mean((result["stage.x"] - self.target) ** 2)))


folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="learn_parameters_"))

# 1. The system: one FMU here, any System can be used. The force input first moves the stage
# within its presliding range (for sigma_0), then makes it slide (for F_c).
system = cosim.System("stage")
system.add("stage", models.build_fmu("stage", folder))
system.expose("u", "stage.u")
force = cosim.SineSweep(frequency=(4.0, 4.0), amplitude=(1.0, 14.0), duration=2.0)  # Hz, N, s
experiment = cosim.Specification(system, step=1e-3, stop=2.0, record=("stage.x",))

# 2. The target signal. With a recording: np.interp(time, recorded_time, recorded_position).
with experiment.prepare() as simulation:
    recorded = simulation.run(parameters=TRUE, inputs={"u": force})
    coarse = simulation.run(inputs={"u": force})  # with the FMU's own start values
target = recorded["stage.x"]

# 3. What to learn: name, range and start. The genes are logarithms by default, so a range may span
# decades; the start is the best value that is known.
genes = [
    ga.Gene("stage.F_c", lower=0.6, upper=60.0, start=6.0, unit="N"),
    ga.Gene("stage.sigma_0", lower=4e4, upper=4e6, start=4e5, unit="N/m"),
]
algorithm = ga.GeneticAlgorithm(genes, ga.Settings(generations=60), seed=1)

# 4. Learn. For two cores, pass concurrent.futures.ThreadPoolExecutor(2) as a third argument: the
# result is the same.
with ga.SimulatedCost(experiment, algorithm.names, PositionError(target), {"u": force}) as cost:
    learned = ga.learn(algorithm, cost)
with experiment.prepare() as simulation:
    matched = simulation.run(parameters=learned.parameters, inputs={"u": force})

print(f"{algorithm.evaluations} runs of 2 s; {learned.stopped}")
print(f"best cost {1e9 * learned.best.cost:.3g} nm RMS, {1e6 * cost.cost(coarse):.3g} um at first")
for gene in genes:
    value, true = learned.parameters[gene.name], TRUE[gene.name]
    error = 100 * (value / true - 1)
    print(f"{gene.name:13} learned {value:.6g} {gene.unit}, true {true:g} ({error:+.4f} %)")

convergence = algorithm.convergence()
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
left.semilogy(convergence["evaluations"], 1e6 * convergence["best_cost"], label="best")
left.semilogy(convergence["evaluations"], 1e6 * convergence["mean_cost"], label="mean")
left.set(xlabel="runs", ylabel="position error, RMS [µm]", title="convergence")
right.plot(recorded.time, 1e3 * coarse["stage.x"], color="tab:gray", label="start values")
right.plot(recorded.time, 1e3 * matched["stage.x"], color="tab:orange", label="learned")
right.plot(recorded.time, 1e3 * target, "k:", label="target")
right.set(xlabel="time [s]", ylabel="position [mm]", title="what is matched")
for axes in (left, right):
    axes.grid(alpha=0.3)
    axes.legend()
figure.savefig(folder / "learn_parameters.png", dpi=150)
print(f"written: {folder / 'learn_parameters.png'}")
