"""What each step brings: from no compensation to the loop that genetic learning found.

The drive's truth enters here, when all is learned: the error is that of its true velocity, on the
drive with its friction times a factor.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.catalog.parameters import HIGH, LOW, friction_law
from stickslip.evaluation.motions import MOTIONS, Motion
from stickslip.evaluation.validation import PHASES, beginnings, covered
from stickslip.fmi.process import Threads
from stickslip.servo.chain_response import ChainResponse
from stickslip.servo.measurement import Array
from stickslip.servo.systems import build_loop
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.tuning.loop_learning import LearnedLoop, LoopStudy
from stickslip.tuning.loop_runs import CHAIN, FEEDFORWARD, OBSERVER, PLAIN, TunedLoop

FRICTION = (0.7, 1.0, 1.3)  # Friction of the drive, relative to its own
STAGES = ("none", "tuned_pi", "identified", "least_squares", "learned")
"""The paper's loop alone; gains tuned without a model; with these the friction as identified and as
least squares found it, fed forward; the loop that was learned."""
RELATIVE = ("creep", "micrometre moves")
"""Motions of several speeds, whose errors are relative to the command."""


@dataclass(frozen=True)
class LoopTuning:
    """The loop as it was learned by several seeds, beside what precedes it."""

    study: LoopStudy  # of the search
    learned: Sequence[LearnedLoop]  # of each seed
    # columns stage, seed, motion, friction, error, unit, Ms, evaluations, and the range of the
    # error over ``PHASES``
    table: pd.DataFrame

    @property
    def best(self) -> LearnedLoop:
        """That of the seed whose cost was least, as it was measured on drive and models."""
        return min(self.learned, key=lambda one: one.cost)

    @cached_property
    def ratios(self) -> pd.DataFrame:
        """The table with ``ratio``, the error relative to that of ``tuned_pi``."""
        keys = ["seed", "motion", "friction"]
        tuned = self.table[self.table["stage"] == "tuned_pi"].set_index(keys)["error"]
        own = self.table.set_index(keys)["error"]
        return self.table.assign(ratio=(own / tuned.reindex(own.index)).to_numpy())

    def by_seed(self, stage: str = "learned") -> pd.DataFrame:
        """Return median and largest ratio of a stage, and its Ms, by seed."""
        rows = self.ratios[self.ratios["stage"] == stage].groupby("seed")
        return rows.agg(median=("ratio", "median"), largest=("ratio", "max"), Ms=("Ms", "max"))

    def summary(self) -> pd.DataFrame:
        """Return median, least and largest ratio of each stage by motion, and its largest Ms."""
        rows = self.ratios.groupby(["stage", "motion"])["ratio"]
        found = {
            stage: {
                **{
                    (motion.name, of): getattr(rows.get_group((stage, motion.name)), of)()
                    for motion in MOTIONS
                    for of in ("median", "min", "max")
                },
                ("Ms", ""): self.table[self.table["stage"] == stage]["Ms"].max(),
            }
            for stage in STAGES
        }
        return pd.DataFrame.from_dict(found, orient="index")

    @property
    def sentence(self) -> str:
        """What the learned loop brings, and what the steps before it do."""
        learned, fitted = self.by_seed(), self.by_seed("least_squares").iloc[0]
        middle, low, high = (100.0 * f(learned["median"]) for f in (np.median, np.min, np.max))
        text = (
            f"the learned loop leaves {middle:.0f} % of the error of a PI controller tuned without "
            f"a model, in the median of {len(MOTIONS)} motions and {len(FRICTION)} levels of "
            f"friction ({low:.0f} to {high:.0f} % over {len(learned)} seeds), and at most "
            f"{100.0 * learned['largest'].max():.0f} % in any; the compensator alone, with these "
            f"gains, leaves {100.0 * fitted['median']:.0f} % and up to "
            f"{100.0 * fitted['largest']:.0f} %; the peak sensitivity Ms is at most "
            f"{learned['Ms'].max():.2f}"
        )
        simpler = sum(one.chosen != "learned" for one in self.learned)
        if simpler:
            text += f"; in {simpler} of the seeds none was worse than the tuned gains in nothing"
        return text

    def fitness(self) -> pd.DataFrame:
        """Return the course of the searches: seed, generation, evaluations, best and mean cost."""
        return courses((one.seed, one.algorithm) for one in self.learned)


def courses(searches: Iterable[tuple[int, ga.Optimiser]]) -> pd.DataFrame:
    """Return the course of searches by their seeds: seed, and the columns of ``convergence``."""
    tables = {seed: search.convergence() for seed, search in searches}
    return pd.concat(tables, names=["seed"]).reset_index("seed").reset_index(drop=True)


def spread(median: float, low: float, high: float) -> str:
    """Return a median with its range, or alone where there is none."""
    ends = f"{low:.2f}", f"{high:.2f}"
    return f"{median:.2f}" if ends[0] == ends[1] else f"{median:.2f} [{ends[0]}, {ends[1]}]"


def validate_loops(
    study: LoopStudy,  # with the friction after least squares
    searched: LoopStudy,  # of the loops that were learned, whose feedforward may be of another law
    # friction law of the drive, and every parameter of its FMU
    law: str,
    truth: Mapping[str, float],
    paper: VelocityLoop,  # the loop of the paper
    identified: Mapping[str, float],  # friction by name, as identified
    learned: Sequence[LearnedLoop],
    *,
    runs: int,  # of the drive, that least squares took
    workers: int = 1,  # motions side by side
) -> LoopTuning:
    """Run all motions with each step."""
    none, own = replace(study, reference=paper), replace(study, friction=identified)
    steps: dict[tuple[str, int], tuple[TunedLoop, int]] = {
        ("none", -1): (none.loop(PLAIN), 0),
        ("tuned_pi", -1): (study.loop(PLAIN), 0),
        ("identified", -1): (own.loop(FEEDFORWARD), 0),
        ("least_squares", -1): (study.loop(FEEDFORWARD), runs),
    }
    before, after = [tuned for tuned, _ in steps.values()], [one.tuned for one in learned]
    steps |= {("learned", one.seed): (one.tuned, one.evaluations) for one in learned}
    drives = [with_friction(law, truth, level) for level in FRICTION]

    def of(motion: Motion) -> list[list[list[float]]]:
        found = motion_errors(study, before, drives, motion)
        return found + motion_errors(searched, after, drives, motion)

    with Threads(workers) as threads:
        found = threads.each(of, MOTIONS)
    peaks = _peaks(study, before, truth["m"]) + _peaks(searched, after, truth["m"])
    rows = []
    for seed in (one.seed for one in learned):
        for k, ((stage, own_seed), (_, evaluations)) in enumerate(steps.items()):
            if own_seed not in (-1, seed):
                continue
            for motion, of_motion in zip(MOTIONS, found, strict=True):
                unit = "1" if motion.name in RELATIVE else "mm/s"
                for level, errors in zip(FRICTION, of_motion[k], strict=True):
                    named = stage, seed, motion.name, level, float(np.median(errors)), unit
                    rows.append((*named, peaks[k], evaluations, min(errors), max(errors)))
    head = ["stage", "seed", "motion", "friction", "error", "unit", "Ms", "evaluations"]
    head += [f"error{LOW}", f"error{HIGH}"]
    return LoopTuning(searched, learned, pd.DataFrame(rows, columns=head))


def motion_errors(
    study: LoopStudy,
    loops: Sequence[TunedLoop],
    drives: Sequence[Mapping[str, float]],  # start values of the drive FMU by name
    motion: Motion,
) -> list[list[list[float]]]:
    """Return the errors of a motion of each loop on each drive, one for each of ``PHASES``.

    It is the RMS over the regions of the error of the true velocity [mm/s], or, of ``RELATIVE``,
    of that error relative to the command.
    """
    rig, loop = study.rig, study.reference
    t = rig.samples(motion.duration)
    v_cmd = motion.command.sample(t)
    inside = [covered(t, spans) for spans in motion.regions.values()]
    system = build_loop(rig.fmus, loop.changed(m_ff=loop.axis.m), CHAIN)
    begun, still = beginnings(system, PHASES), {"a_cmd": np.zeros(len(v_cmd))}
    relative = motion.name in RELATIVE

    def error(v: Array) -> float:
        squares = [np.mean((v - v_cmd)[part] ** 2) for part in inside]
        if relative:
            squares = [
                x / np.mean(v_cmd[part] ** 2) for x, part in zip(squares, inside, strict=True)
            ]
        return float(np.sqrt(np.mean(squares))) * (1.0 if relative else 1e3)

    with system.prepare(step=rig.T_s, stop=float(t[-1]), record=["drive.v"]) as simulation:

        def errors(tuned: TunedLoop, drive: Mapping[str, float]) -> list[float]:
            values = tuned.parameters() | {f"drive.{name}": x for name, x in drive.items()}
            commands = still | tuned.loop.commands(v_cmd)
            return [error(simulation.run(values | phase, commands)["drive.v"]) for phase in begun]

        return [[errors(tuned, drive) for drive in drives] for tuned in loops]


def with_friction(law: str, truth: Mapping[str, float], level: float) -> dict[str, float]:
    """Return the drive's parameters of friction, times a factor."""
    friction = friction_law(law)
    own = {n: value for n, value in truth.items() if n.partition("[")[0] in friction.parameters}
    return friction.share(own, level)


def _peaks(study: LoopStudy, loops: Sequence[TunedLoop], m: float) -> list[float]:
    """Return the peak sensitivity Ms of each loop on the drive's true mass, from runs of FMUs."""
    own = ("compensator.", f"{OBSERVER}.")
    found = []
    with ChainResponse(study.rig.fmus, study.reference, CHAIN) as response:
        for one in loops:
            values = {n: value for n, value in one.parameters().items() if n.startswith(own)}
            found.append(response.of(one.loop, values, study.friction["F_c"], m).peak)
    return found
