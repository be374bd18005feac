"""The cost of a loop on the drives that a log supports, in every motion of the trial.

Errors are against the command, for the motion without friction depends on the gains, too. What
counts of a motion is the RMS of the errors over all drives and levels of friction, relative to that
of the present loop, and the mean of the ratios on each of them. The median at each level would ask
most where the present loop happens to fit.
"""

import math
import threading
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from functools import partial

import numpy as np

from stickslip import cosim, ga
from stickslip.identification.criteria.runs import Outcome
from stickslip.loops.drive_loop import DriveLoop
from stickslip.servo.axis import ControlError
from stickslip.servo.chain_response import ChainResponse, frequencies
from stickslip.servo.measurement import Array
from stickslip.servo.sensitivity import OpenLoop
from stickslip.thresholds import kept
from stickslip.trial import benefit
from stickslip.trial.family import Command, Drive
from stickslip.tuning.loop_learning import QUIET
from stickslip.tuning.search import STEEP, Ratios, mean_of

EXCESS = 1e3  # cost of a candidate beyond a limit, times by how much


class FamilyCost(ExitStack):
    """The cost of candidates, and what they do on the whole family; to be used in ``with``."""

    fatal = (cosim.CosimError,)

    def __init__(
        self, bench: benefit.Bench, start: DriveLoop, masses: Sequence[float], names: Sequence[str]
    ) -> None:
        super().__init__()
        self.bench, self.start, self.masses, self.names = bench, start, masses, names
        loop = start.loop.changed(m_ff=start.loop.axis.m)  # the loop takes an acceleration
        record = ("drive.v", "drive.x", "drive.F_m")
        self._runs = self.enter_context(benefit.LoopRuns(bench, loop, start.chain, record))
        observers = [one for one in start.chain if one.name == "observer"]
        folder = bench.fmus(bench.law.name, observers)
        self._chain = self.enter_context(ChainResponse(folder, loop, observers, self._runs.speed))
        self._lock = threading.Lock()  # of the one simulation behind it
        self.cells = [cell for cell in bench.cells if cell[0].decides]
        searched = {one.name for one in searched_of([drive for drive, _ in self.cells])}
        self.few = [cell for cell in self.cells if cell[0].name in searched]
        self.first = [cell for cell in self.few if self._is_first(cell)]
        # Errors of the present loop; small moves of several lengths have one name.
        self._present: dict[tuple[str, Command], tuple[float, ...]] = {}
        self._run_present(self.few)
        self.F_c = bench.drives[0].parameters["F_c"]
        self._own = self.forces(start)

    def sensitivity(self, one: DriveLoop) -> float:
        """Return the largest peak sensitivity Ms at the masses; infinite if it is unstable."""
        axes = [OpenLoop(one.loop, k * one.loop.axis.m, frequencies(one.loop)) for k in self.masses]
        values = {n: x for n, x in one.parameters.items() if n.startswith("observer.")}
        try:
            with self._lock:
                found = self._chain.responses(axes, values, self.F_c)
        except cosim.SimulationError:  # an observer that is unstable by itself
            return math.inf
        return max((response.peak for response in found), default=math.inf)

    def forces(self, one: DriveLoop) -> tuple[float, float]:
        """Return RMS change a sample, and peak, of the force on the first drive [N]."""
        return _forces(self._each(one, self.first))

    def excess(self, one: DriveLoop) -> float:
        """Return peak sensitivity, chatter or force over its limit, whichever is the largest.

        It is infinite where the loop is unstable or runs away; above the limit of the peak
        sensitivity nothing is run.
        """
        Ms = self.sensitivity(one) / kept.SENSITIVITY
        if Ms > 1.0:
            return Ms
        try:
            return max(Ms, self._too_much(self.forces(one)))
        except cosim.SimulationError:
            return math.inf

    def rows(self, one: DriveLoop, cells: Sequence[benefit.Cell] = ()) -> benefit.Rows:
        """Return the errors of a loop and of the present one, by default wherever they decide."""
        cells = cells or self.cells
        self._run_present(cells)
        return self._compared(cells, self._each(one, cells))

    def __call__(self, values: Array) -> float:
        """Return the cost of a candidate (k,), more beyond a limit; raise CandidateFailed."""
        return self.together(values[np.newaxis])[0]()

    def together(self, rows: Array) -> list[Callable[[], float]]:
        """Run candidates (n, k) in lanes, and return functions of which each gives a cost."""
        loops: dict[int, DriveLoop] = {}
        unstable: dict[int, ControlError] = {}
        for k, values in enumerate(rows.tolist()):
            try:
                loops[k] = self.start.with_values(dict(zip(self.names, values, strict=True)))
            except ControlError as error:
                unstable[k] = error
        ratio = {k: self.sensitivity(one) / kept.SENSITIVITY for k, one in loops.items()}
        robust = [k for k in loops if ratio[k] <= 1.0]
        tried = self._runs.outcomes([loops[k].parameters for k in robust], self.few)
        runs = dict(zip(robust, tried, strict=True))

        def cost(k: int) -> float:
            if error := unstable.get(k):
                raise ga.CandidateFailed(str(error)) from error
            excess, own = ratio[k], list(zip(self.few, runs.get(k, ()), strict=False))
            try:
                if own:
                    forces = _forces([run for cell, run in own if self._is_first(cell)])
                    excess = max(excess, self._too_much(forces))
            except cosim.SimulationError:
                excess = math.inf
            if not math.isfinite(excess):
                raise ga.CandidateFailed("the loop is unstable at one of the masses, or runs away")
            if excess > 1.0:
                return EXCESS * excess
            return cost_of(ratios(self._compared(self.few, [run for _, run in own])))

        return [partial(cost, k) for k in range(len(rows))]

    def _is_first(self, cell: benefit.Cell) -> bool:
        return cell[0] is self.bench.drives[0]

    def _too_much(self, forces: tuple[float, float]) -> float:
        """Return chatter or peak over its limit, whichever is the larger."""
        limits = kept.CHATTER * self.F_c, kept.FORCE * self.bench.datasheet.peak_force
        own = self._own[0] / QUIET, self._own[1]
        return max(force / max(both) for force, *both in zip(forces, limits, own, strict=True))

    def _run_present(self, cells: Sequence[benefit.Cell]) -> None:
        """Run the present loop in cells in which it has not been run yet."""
        left = [one for one in cells if (one[0].name, one[1]) not in self._present]
        for cell, run in zip(left, self._each(self.start, left), strict=True):
            self._present[cell[0].name, cell[1]] = benefit.errors_of(run, self._targets(cell[1]))

    def _each(self, one: DriveLoop, cells: Sequence[benefit.Cell]) -> list[Outcome]:
        """Return the run of the FMUs of a loop in each cell, or why it failed."""
        return self._runs.outcomes([one.parameters], cells, in_lanes=False)[0]

    def _targets(self, command: Command) -> dict[str, Array]:
        """Return what the velocity and, in a cascade, the position should be (n,), by signal."""
        targets = {"drive.v": command.v_cmd}
        if self.start.loop.K_x:
            targets["drive.x"] = self._runs.inputs[command]["x_cmd"][: len(command.v_cmd)]
        return targets

    def _compared(self, cells: Sequence[benefit.Cell], runs: Sequence[Outcome]) -> benefit.Rows:
        present = [self._present[drive.name, command] for drive, command in cells]
        both = zip(cells, runs, strict=True)
        return benefit.rows_of(
            cells, present, [benefit.errors_of(run, self._targets(cell[1])) for cell, run in both]
        )


def _forces(runs: Iterable[Outcome]) -> tuple[float, float]:
    """Return the largest RMS change, and peak, of the force [N]; raise what a run has raised."""
    chatter = peak = 0.0
    for run in runs:
        if isinstance(run, cosim.SimulationError):
            raise run
        force = run["drive.F_m"]
        chatter = max(chatter, float(np.std(np.diff(force))))
        peak = max(peak, float(np.abs(force).max()))
    return chatter, peak


def searched_of(drives: Sequence[Drive]) -> list[Drive]:
    """Return the drives of the search: as fitted and one of each law, at all levels of friction."""
    found: dict[tuple[object, float], Drive] = {}
    first = drives[0].name
    for one in drives:
        fitted = one.name.startswith(first)
        found.setdefault((fitted or one.law, one.level), one)
    return [*found.values()]


def cost_of(found: Ratios) -> float:
    """Return the mean of the ratios of RMS errors, and more where others exceed 1."""
    rms = {key: ratio for key, ratio in found.items() if "RMS" in key}
    worse = sum(max(ratio - 1.0, 0.0) for key, ratio in found.items() if key not in rms)
    return mean_of(rms) + STEEP * worse


def ratios(rows: benefit.Rows) -> Ratios:
    """Return what a loop leaves of the errors of the present one, by motion, figure and kind.

    ``RMS`` is that over all drives and levels of friction on which the present loop does not run
    away, so that the drives with the largest errors count most; ``each`` is the geometric mean of
    the ratios on each of them, where all drives count alike.
    """
    found: Ratios = {}
    groups: dict[tuple[str, str], list[benefit.TrialError]] = {}
    for row in rows:
        if math.isfinite(row.without):
            groups.setdefault((row.command, row.figure), []).append(row)
    for key, some in groups.items():
        squares = np.sum([(row.compensated**2, row.without**2) for row in some], axis=0)
        found[*key, "RMS"] = float(np.sqrt(squares[0] / squares[1]))
        found[*key, "each"] = benefit.geometric_mean(some)
    return found
