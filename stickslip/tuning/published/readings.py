"""What the paper leaves open: our reading of each place, another one, and what that changes.

Two kinds: a place that changes how the errors are evaluated is evaluated again on the runs that
there are; one that changes the learning is learned again from the same coarse starts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.catalog.parameters import friction_law
from stickslip.catalog.space import ParameterSpace
from stickslip.evaluation.motions import regions_after, windows
from stickslip.evaluation.validation import METRICS, Run, tracking_errors
from stickslip.servo.datasheet import REGION, VALIDATION
from stickslip.servo.measurement import Array, smoothed
from stickslip.tuning.learning import repair
from stickslip.tuning.published.study import PAPER_COST, Method, Published

Velocity = Callable[[Run], Array]

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
        Method(repair=repair(ParameterSpace.of(friction_law()), None)),
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
    T_s = float(published.without.t[1])
    rows: list[tuple[str, str, bool, tuple[float, float], Velocity]] = [
        (
            "Table 4, regions",
            f"from {_ms(REGION)} after the instant",
            True,
            REGION,
            _shown("measured"),
        ),
        ("Table 4, regions", "from 0 to 70 ms", False, (0.0, REGION[1]), _shown("measured")),
        ("Table 4, regions", "from 0 to 150 ms", False, (0.0, 0.150), _shown("measured")),
        ("(8a), velocity", "encoder, low-passed at 117 Hz", True, REGION, _shown("measured")),
        ("(8a), velocity", "encoder, low-passed at 234 Hz", False, REGION, _encoder(T_s, 234.0)),
        ("(8a), velocity", "encoder, not filtered", False, REGION, _encoder(T_s, None)),
        ("(8a), velocity", "true", False, REGION, _shown("true")),
    ]
    learned = [one.with_learned for one in published.seeds]
    table = []
    for place, reading, ours, region, velocity in rows:
        row: dict[str, object] = {"place": place, "reading": reading, "ours": ours}
        for label, runs in (("without", [published.without]), ("with", learned)):
            row |= _errors(label, runs, region, velocity)
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


def _shown(name: str) -> Velocity:
    def velocity(run: Run) -> Array:
        return run.v[name]

    return velocity


def _encoder(T_s: float, cutoff: float | None) -> Velocity:
    def velocity(run: Run) -> Array:
        v = np.gradient(run.x_enc, T_s)
        return v if cutoff is None else smoothed(v, T_s, cutoff)

    return velocity


def _errors(
    label: str,
    runs: Iterable[Run],
    region: tuple[float, float],
    velocity: Velocity,
) -> dict[str, object]:
    """Return the median over runs of each error [mm/s] by name."""
    found: dict[str, list[float]] = {}
    for run in runs:
        error = 1e3 * (run.v_cmd - velocity(run))
        for name, spans in regions_after(windows(VALIDATION), region).items():
            for metric, value in tracking_errors(run.t, error, spans).items():
                found.setdefault(f"{label}_{name}_{metric}", []).append(value)
    return {name: float(np.median(values)) for name, values in found.items()}


def _ms(region: tuple[float, float]) -> str:
    return " to ".join(f"{1e3 * edge:g}" for edge in region) + " ms"
