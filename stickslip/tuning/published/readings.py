"""What the paper leaves open: our reading of each place, another one, and what that changes.

Two kinds: a place that changes how the errors are evaluated is evaluated again on the runs that
there are; one that changes the learning is learned again from the same coarse starts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.evaluation.motions import Span, regions_after, windows
from stickslip.evaluation.validation import METRICS, Run, tracking_errors
from stickslip.fmi.process import Threads
from stickslip.identification.stages import Identification
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.measurement import Array, smoothed
from stickslip.servo.paper_commands import REGION, VALIDATION
from stickslip.servo.systems import Feed
from stickslip.tuning.published.study import (
    PAPER_COST,
    Method,
    Published,
    learn_as_published,
    slow_motions,
)

TABLES = ("fitness", "table4", "learned", "readings", "readings_evaluation", "slow_motions")
"""The names of the study's tables, as which they are written."""
ABSOLUTE_STEP = 1e-4


def rounded_absolutely(values: Array, genes: Sequence[ga.Gene]) -> Array:
    """Round candidates (n, k) to multiples of Table 3's resolution in SI units."""
    del genes
    return np.asarray(np.rint(values / ABSOLUTE_STEP) * ABSOLUTE_STEP)


def rounded_relatively(values: Array, genes: Sequence[ga.Gene]) -> Array:
    """Round candidates (n, k) to steps of Table 3's resolution times the value."""
    del genes
    return np.asarray(np.exp(np.rint(np.log(values) / ABSOLUTE_STEP) * ABSOLUTE_STEP))


@dataclass(frozen=True)
class LearningReading:
    """A place that is read in another way, and learned so.

    Attributes
    ----------
    place : where in the paper
    ours, other : both readings, in words
    """

    place: str
    ours: str
    other: str
    method: Method


def _settings(**changes: object) -> Method:
    return Method(replace(ga.PAPER, **changes))  # type: ignore[arg-type]  # names of fields


_COARSELY = "“coarsely” (2.4, 3.2)"
_RESOLUTION = "Table 3, resolution 0.0001"
_OF_RANGE = "of each gene’s range"

READINGS = (
    LearningReading(
        _COARSELY,
        "factors on the identified values, log-normal: forces 20 %, stiffness and damping 35 %, "
        "Stribeck velocity 70 %",
        "the identified values as they are",
        Method(width=0.0),
    ),
    LearningReading(_COARSELY, "the same", "twice as wide", Method(width=2.0)),
    LearningReading("(4)", "exponent 1, as printed", "exponent 2", Method(delta=2.0)),
    LearningReading(
        "(6)",
        "velocity of the encoder, low-passed at 117 Hz without phase lag",
        "differences of the encoder, not filtered",
        Method(cutoff=None),
    ),
    LearningReading("(7)", "k₁ = k₂ = 1", "k₁ = k₂ = 0.5", _settings(k1=0.5, k2=0.5)),
    LearningReading(
        "Fig. 2, input of the compensator",
        "velocity of the nominal loop",
        "velocity command",
        Method(feed="command"),
    ),
    LearningReading(
        "Step 1, “based on experience”",
        "the start, and nine candidates anywhere in the range",
        "all ten within about 30 % of the start",
        _settings(near_share=1.0, near_spread=0.003),
    ),
    LearningReading(
        "Step 1, limits of the genes",
        "F_s below F_c is allowed",
        "F_s below F_c is exchanged with it",
        Method(repair=ga.AtLeast("F_s", "F_c")),
    ),
    LearningReading(
        "Step 2, “real number strings”",
        "linear between the limits",
        "logarithmic between the limits",
        _settings(encoding="log"),
    ),
    LearningReading(
        "Step 4, “elitist strategy”",
        "the two best go on, parents come from all by fitness",
        "besides, a child takes its parent’s place only if it costs no more",
        _settings(survival="rival"),
    ),
    LearningReading(
        "Step 4, mutation",
        "a new value anywhere in the range",
        "a step of twice the population’s standard deviation",
        _settings(mutation="spread"),
    ),
    LearningReading(
        _RESOLUTION,
        _OF_RANGE,
        "absolute, in SI units",
        Method(replace(ga.PAPER, resolution=None), rounded_absolutely),
    ),
    LearningReading(
        _RESOLUTION,
        _OF_RANGE,
        "relative to the value",
        Method(replace(ga.PAPER, resolution=None), rounded_relatively),
    ),
)
"""Readings that learn in another way."""

ERRORS = tuple(f"{region}_{metric}" for region in ("start", "reverse") for metric in METRICS)
"""Columns of Table 4's four errors [mm/s]."""


def learning_row(reading: LearningReading, ours: Published, other: Published) -> dict[str, object]:
    """Return a row of the table: medians over the seeds that both have.

    Keys: place, ours, other, seeds, then for each of both ``_ours`` and ``_other``: cost, its share
    of the start's cost, the four errors with compensation, and worse, the share of seeds whose
    E_rms on the trapezoid is larger than their start's.
    """
    seeds = {one.seed for one in other.seeds}
    same = replace(ours, seeds=tuple(one for one in ours.seeds if one.seed in seeds))
    row: dict[str, object] = {
        "place": reading.place,
        "ours": reading.ours,
        "other": reading.other,
        "seeds": len(seeds),
    }
    for label, published in (("ours", same), ("other", other)):
        row |= {f"{name}_{label}": value for name, value in summary(published).items()}
    return row


def summary(published: Published) -> dict[str, float]:
    """Return medians over seeds: cost, fall, the four errors [mm/s]; and worse, see above."""
    costs, starts = published.final_costs(), published.start_costs()
    table = published.table4()
    table = table[table["velocity"] == "measured"]
    errors = table["with"].groupby(table["region"] + "_" + table["metric"]).median()
    return {
        "cost": float(np.median(costs)),
        "fall": float(np.median(costs / starts)),
        **{name: float(errors[name]) for name in ERRORS},
        "worse": worse(table),
    }


def worse(table: pd.DataFrame) -> float:
    """Return the share of seeds that track worse than their start, by E_rms of both regions.

    Parameters
    ----------
    table : rows of ``Published.table4`` of one velocity
    """
    rms = table[table["metric"] == "E_rms"].set_index("seed")[["start", "with"]]
    sums = (rms**2).groupby("seed").sum()
    return float((sums["with"] > sums["start"]).mean())


def evaluation_readings(published: Published) -> pd.DataFrame:
    """Tabulate readings of how the errors of Table 4 are evaluated, on the runs of all seeds.

    Columns place, reading, ours (whether it is ours), then ``without_`` and ``with_`` each of the
    four errors [mm/s]; with compensation the median over seeds.
    """
    regions, velocity = "Table 4, regions", "(8a), velocity"
    rows: list[tuple[str, str, bool, Span, str | float | None]] = [
        (regions, f"from {_ms(REGION)} after the instant", True, REGION, "measured"),
        (regions, "from 0 to 70 ms", False, (0.0, REGION[1]), "measured"),
        (regions, "from 0 to 150 ms", False, (0.0, 0.150), "measured"),
        (velocity, "encoder, low-passed at 117 Hz", True, REGION, "measured"),
        (velocity, "encoder, low-passed at 234 Hz", False, REGION, 234.0),
        (velocity, "encoder, not filtered", False, REGION, None),
        (velocity, "true", False, REGION, "true"),
    ]
    learned = [one.with_learned for one in published.seeds]
    table = []
    for place, reading, ours, region, shown in rows:
        row: dict[str, object] = {"place": place, "reading": reading, "ours": ours}
        for label, runs in (("without", [published.without]), ("with", learned)):
            errors = pd.DataFrame([_errors(run, region, shown) for run in runs]).median()
            row |= {f"{label}_{name}": float(errors[name]) for name in ERRORS}
        table.append(row)
    return pd.DataFrame(table)


def threshold_reading(published: Published, threshold: float = PAPER_COST) -> dict[str, float]:
    """Return what a threshold epsilon in Step 3 changes [m^2/s^2].

    Keys: threshold, stops (share of seeds that reach it), generations (median, of those), and
    ``cost`` (median over all seeds of where they then stop).
    """
    reached, costs = [], []
    for one in published.seeds:
        line = one.algorithm.convergence()
        below = line[line["best_cost"] <= threshold]
        reached += below["generation"].tolist()[:1]
        costs.append(float((below if len(below) else line.tail(1))["best_cost"].iloc[0]))
    return {
        "threshold": threshold,
        "stops": len(reached) / len(published.seeds),
        "generations": float(np.median(reached)) if reached else float("nan"),
        "cost": float(np.median(costs)),
    }


def _errors(run: Run, region: Span, shown: str | float | None) -> dict[str, float]:
    """Return each error [mm/s] by name.

    Parameters
    ----------
    shown : name of a velocity, or the low-pass of that of the encoder [Hz], None for none
    """
    if isinstance(shown, str):
        v = run.v[shown]
    else:
        T_s = float(run.t[1])
        v = np.gradient(run.x_enc, T_s)
        v = v if shown is None else smoothed(v, T_s, shown)
    error = 1e3 * (run.v_cmd - v)
    return {
        f"{name}_{metric}": value
        for name, spans in regions_after(windows(VALIDATION), region).items()
        for metric, value in tracking_errors(run.t, error, spans).items()
    }


def _ms(region: Span) -> str:
    return " to ".join(f"{1e3 * edge:g}" for edge in region) + " ms"


@dataclass(frozen=True)
class WholeStudy:
    """What came out.

    Attributes
    ----------
    published : our reading, all seeds
    readings : a row for each other reading that learns in another way, see ``learning_row``
    slow : what ``slow_motions`` returns
    """

    published: Published
    readings: pd.DataFrame
    slow: pd.DataFrame

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return all tables by the names of ``TABLES``."""
        ours, read = self.published, (self.readings, self.evaluations)
        found = (ours.fitness(), ours.table4(), ours.learned(), *read, self.slow)
        return dict(zip(TABLES, found, strict=True))

    @property
    def evaluations(self) -> pd.DataFrame:
        """The readings that evaluate the same runs in another way, see ``evaluation_readings``."""
        return evaluation_readings(self.published)

    @property
    def threshold(self) -> dict[str, float]:
        """What a threshold in Step 3 changes, see ``threshold_reading``."""
        return threshold_reading(self.published)


def study_as_published(
    rig: FmuRig,
    identification: Identification,
    seeds: Sequence[int],
    *,
    reading_seeds: int,
    feed: Feed = "nominal",
    workers: int = 1,
    on_stage: Callable[[str], object] = lambda _: None,
) -> WholeStudy:
    """Learn as published from coarse starts, and again under each other reading.

    Parameters
    ----------
    seeds : of our reading
    reading_seeds : how many of them, the first, learn under each other reading
    feed : what drives the compensator
    """

    def learned(method: Method, chosen: Sequence[int], workers: int) -> Published:
        loop, found = identification.loop, identification.estimates
        return learn_as_published(rig, loop, found, chosen, method, workers)

    on_stage(f"learning as published, {len(seeds)} seeds")
    ours = learned(Method(feed=feed), seeds, workers)
    if reading_seeds:
        on_stage(f"{len(READINGS)} other readings, {reading_seeds} seeds each")

    def row(reading: LearningReading) -> dict[str, object]:
        method = reading.method
        if method.feed == Method.feed:
            method = replace(method, feed=feed)
        return learning_row(reading, ours, learned(method, seeds[:reading_seeds], 1))

    with Threads(workers) as threads:
        rows = threads.each(row, READINGS if reading_seeds else ())
    columns = list(learning_row(READINGS[0], ours, ours))  # a table also where nothing is in it
    on_stage("slow motions")
    slow = slow_motions(rig, identification.loop, ours)
    return WholeStudy(ours, pd.DataFrame(rows, columns=columns), slow)
