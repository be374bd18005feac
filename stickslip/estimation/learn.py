"""From one recording to a drive's parameters, with how well each is known.

Search (genetic algorithm, inverse model) -> fit (least squares) -> for a known loop: output error,
whitened, and corrected by replicas of the experiment -> certainty.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

import ga
from stickslip.errors import UsageError
from stickslip.estimation.certainty import NOT_VISIBLE, Certainty, certainty, profiles
from stickslip.estimation.controller_check import ControllerCheck, check_controller
from stickslip.estimation.figures import Figures, figures
from stickslip.estimation.fit import BLOCKS, Fit, fit, value_errors
from stickslip.estimation.inverse import InverseModel
from stickslip.estimation.motion import position_of
from stickslip.estimation.output_error import OutputError
from stickslip.estimation.replica import RUNS, Corrected, correct
from stickslip.estimation.search import Search, search, with_linear
from stickslip.estimation.start import Start, begin
from stickslip.estimation.unknowns import LEVEL, SOUGHT, Values
from stickslip.measurement import Array
from stickslip.recording import Recording

JudgeName = Literal["auto", "output error", "inverse model"]
AGREES = 0.01
"""Relative error of the commanded force up to which a controller counts as known."""
MODEL_ERROR = 2.0
"""How many times larger than encoder and noise explain the residual of the loop may be."""
WHITENINGS = 2
WORTH = 1.1
"""By which factor the mean square must fall to make F_s > F_c believed where it is hardly seen."""
DOUBT = 0.12
"""Share of the bias taken off that stays as doubt."""


@dataclass(frozen=True)
class Task:
    """What to learn from.

    Attributes
    ----------
    fmus : folder of the FMUs
    gains : of the controller FMU by name; None when the controller is not known
    judge : how candidates are judged; ``auto`` takes what the recording allows
    search : which algorithm, where it runs
    seed : of the search
    seeds : how many searches, each with a seed of its own
    """

    fmus: Path
    recording: Recording
    gains: Mapping[str, float] | None = None
    judge: JudgeName = "auto"
    search: Search = field(default_factory=Search)
    seed: int = 0
    seeds: int = 1


@dataclass(frozen=True)
class Estimation:
    """What was learned.

    Attributes
    ----------
    judge, reason : how candidates were judged in the end, and why
    fit : with coordinates, residual and covariance
    known : certainty by name: LuGre's five, m and b
    F_0, delay : constant force against the motor [N]; of the force [s]
    profiles : see ``certainty.profiles``
    searches : a row for each seed: seed, evaluations, cost, LuGre's five after the local fit
    algorithm : the search that led to the result
    figures : how near the model comes to the recording
    controller : the check of the controller; None when it is not known
    remarks : what was done to the recording
    model_error : residual of the loop over what encoder and noise explain; NaN without the loop
    """

    recording: Recording
    judge: str
    reason: str
    start: Start
    fit: Fit
    known: dict[str, Certainty]
    F_0: float
    delay: float
    profiles: pd.DataFrame
    searches: pd.DataFrame
    algorithm: ga.Optimiser
    figures: Figures
    controller: ControllerCheck | None
    model_error: float
    gains: Mapping[str, float] | None = None
    remarks: tuple[str, ...] = ()

    @property
    def parameters(self) -> dict[str, float]:
        """All values by name, in SI units."""
        return self.fit.parameters


def learn(
    task: Task,
    on_stage: Callable[[str], object] = lambda _: None,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
) -> Estimation:
    """Learn the parameters of the drive that made a recording.

    Raises
    ------
    IdentificationError
        When the recording does not show a drive that slides.
    UsageError
        When it lacks a signal that the judge needs.
    ga.NothingLearned
        When no candidate could be run.
    """
    recording, check = task.recording, None
    if task.gains is not None:
        on_stage("checking the controller")
        check = check_controller(task.fmus, recording, task.gains)
        if recording.force is None and recording.friction is None:
            recording = replace(recording, force=check.force)
    recording, remarks = _against_motion(recording)
    task = replace(task, recording=recording)
    with InverseModel(task.fmus, recording) as inverse:
        start = begin(inverse, recording)
        on_stage("searching")
        found, rows, algorithm = _search(task, inverse, start, on_generation)
        judge, reason = _choose(task, check)
        corrected = None
        if judge == OutputError.name and task.gains is not None:
            on_stage("fitting the known loop")
            corrected = _output_error(task, task.gains, start, found)
            if corrected.model_error > MODEL_ERROR and task.judge == "auto":
                judge = InverseModel.name
                reason = (
                    f"the loop's residual is {corrected.model_error:.2g} times what encoder and "
                    "noise explain, so the drive has what the model has not, and the mean force "
                    "decides"
                )
        on_stage("judging what is known")
        model_error = corrected.model_error if corrected else float("nan")
        if judge == OutputError.name and corrected and task.gains is not None:
            errors, table = _known_loop(task, task.gains, corrected)
            best, degrees = corrected.fit, RUNS - 1
        else:
            best, degrees = found, BLOCKS - len(found.q)
            errors = found.errors()
            table = profiles(found, inverse.residual, errors)
        shown = figures(task.fmus, recording, inverse, best.parameters, task.gains, check)
    names = SOUGHT if not inverse.measures_friction else SOUGHT[:5]
    known = {name: certainty(name, best, errors, degrees) for name in names}
    return Estimation(
        recording,
        judge,
        reason,
        start,
        best,
        known,
        best.parameters["F_0"],
        best.parameters["delay"],
        table,
        rows,
        algorithm,
        shown,
        check,
        model_error,
        task.gains,
        remarks,
    )


def _search(
    task: Task,
    inverse: InverseModel,
    start: Start,
    on_generation: Callable[[ga.Optimiser], object] | None,
) -> tuple[Fit, pd.DataFrame, ga.Optimiser]:
    """Search with each seed, finish each locally, and return the best with a table of all."""
    fits, algorithms, rows = [], [], []
    for seed in range(task.seed, task.seed + task.seeds):
        algorithm = search(inverse, start, seed, _of_seed(task, seed), on_generation)
        values = with_linear(inverse, start, algorithm.best.values)
        found = fit(inverse, start.unknowns, start.unknowns.coordinates(values))
        fits.append(found)
        algorithms.append(algorithm)
        rows.append(
            {
                "seed": seed,
                "evaluations": algorithm.evaluations,
                "cost": found.noise,
                **{name: found.parameters[name] for name in SOUGHT},
            }
        )
    if task.seeds > 1:
        for seed in range(task.seed, task.seed + task.seeds):
            own = _of_seed(task, seed).execution.checkpoint
            if own is not None:
                own.unlink(missing_ok=True)
    best = int(np.argmin([found.noise for found in fits]))
    return _without_stribeck(inverse, fits[best]), pd.DataFrame(rows), algorithms[best]


def _against_motion(recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """Turn a measured friction that drives the motion, by the sign of its work."""
    if recording.force is not None or recording.friction is None:
        return recording, ()
    position = position_of(recording)
    work = float(recording.friction[1:] @ np.diff(position))
    if work >= 0.0:
        return recording, ()
    turned = replace(recording, friction=-recording.friction)
    return turned, ("the friction logged does work on the motion: its sign was turned",)


def _of_seed(task: Task, seed: int) -> Search:
    """Return how to search; each of several seeds has a checkpoint of its own."""
    path = task.search.execution.checkpoint
    if path is None or task.seeds == 1:
        return task.search
    own = path.with_name(f"{path.stem}.seed{seed}{path.suffix}")
    return replace(task.search, execution=replace(task.search.execution, checkpoint=own))


def _without_stribeck(inverse: InverseModel, found: Fit) -> Fit:
    """Return a fit with F_s = F_c, if the recording does not ask for more.

    A rise of friction towards rest that nobody saw would be compensated all the same, and a force
    that is not there pushes the drive.
    """
    if certainty("F_s", found, found.errors(), BLOCKS).visible != NOT_VISIBLE:
        return found
    level = found.unknowns.upper.copy()
    level[0] = LEVEL
    q = found.q.copy()
    q[0] = 0.0
    flat = fit(inverse, replace(found.unknowns, upper=level), q)
    return flat if flat.noise < WORTH * found.noise else found


def _choose(task: Task, check: ControllerCheck | None) -> tuple[str, str]:
    """Return the judge and why."""
    loop, inverse = OutputError.name, InverseModel.name
    if task.judge == loop and check is None:
        raise UsageError(
            "the output error needs the controller that made the log: give its gains, "
            "or judge by the inverse model"
        )
    if task.judge != "auto":
        return task.judge, "asked for"
    if task.recording.friction is not None and task.recording.force is None:
        return inverse, "friction itself was measured"
    if check is None:
        return inverse, "the controller is not known, so the loop cannot be run again"
    if np.isnan(check.error):
        return loop, "the controller is known and no force was logged"
    if check.error > AGREES:
        return inverse, (
            f"the controller given commands a force that differs by {100 * check.error:.2g} % from "
            "the one logged, so the loop is not known well enough to run it again"
        )
    return loop, (
        f"the controller is known and commands the logged force within {100 * check.error:.2g} %"
    )


def _output_error(task: Task, gains: Mapping[str, float], start: Start, found: Fit) -> Corrected:
    """Fit the loop from the inverse model's values on: plain, then whitened, then corrected."""
    unknowns = start.unknowns
    lower = unknowns.lower.copy()
    lower[-1] = 1e-3  # a lag, in samples; the inverse model's delay may be negative
    unknowns = replace(unknowns, lower=lower)
    values: Values = {**found.parameters, "delay": 0.2 * task.recording.T_s}
    with OutputError(task.fmus, task.recording, gains) as judge:
        fitted = fit(judge, unknowns, unknowns.coordinates(values))
        for _ in range(WHITENINGS):
            judge.whiten(fitted.parameters)
            fitted = fit(judge, unknowns, fitted.q)
        return correct(judge, fitted, task.fmus, task.recording, gains, task.seed)


def _known_loop(
    task: Task, gains: Mapping[str, float], corrected: Corrected
) -> tuple[dict[str, float], pd.DataFrame]:
    """Return standard errors by name [SI], and the profiles."""
    best = corrected.fit
    bias = np.outer(corrected.bias, corrected.bias) * DOUBT**2
    errors = value_errors(best.unknowns, best.q, best.covariance + bias)
    with OutputError(task.fmus, task.recording, gains) as judge:
        judge.whitening = corrected.whitening

        def residual(values: Values) -> Array:
            return judge.residual(values) - corrected.mean

        return errors, profiles(best, residual, errors)
