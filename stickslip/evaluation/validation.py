"""Section 4.2: the trapezoid with and without compensation, evaluated by (8a), (8b) and (9).

The figures of a run depend on where within an encoder step the drive begins. One run is one draw:
how the encoder's steps fall changes the largest errors by some ten percent, and a change of a
parameter by 1e-10, as another processor makes, draws again. Published figures are therefore medians
over ``PHASES``, with their range. Each phase has other noise.
"""

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from stickslip import cosim
from stickslip.catalog.parameters import HIGH, LOW
from stickslip.evaluation.motions import Regions, Span, regions_after, trapezoid, windows
from stickslip.identification.criteria.runs import require_bounded
from stickslip.rigs.contract import Rig
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.measurement import Array, measured_velocity
from stickslip.servo.systems import paper_loop
from stickslip.servo.velocity_loop import VelocityLoop

Key = TypeVar("Key", bound=Hashable)

ONCE = (0.0,)  # the drive begins where its FMU does
PHASES = tuple(sorted((k / 9.0 for k in range(-4, 5)), key=abs))
"""Where the drive begins, in steps of the encoder from where its FMU does; at each of them the
encoder shows the same position at first."""


def beginnings(system: cosim.System, phases: Sequence[float]) -> list[dict[str, float]]:
    """Return for each phase the values with which the drive of a system begins a run."""
    variables = system.components["drive"].variables
    x, step = (cast(float, variables[name].start) for name in ("x", "encoder_step"))
    seed, seeds = cast(int, variables["seed"].start), 1 + int(variables["seed"].maximum or 0)
    return [
        {"drive.x": x + phase * step, "drive.seed": (seed + k) % seeds}
        for k, phase in enumerate(phases)
    ]


def repetitions(found: Iterable[Mapping[Key, float]], names: Sequence[str]) -> pd.DataFrame:
    """Tabulate figures by keys (an index with these names), with a column for each repetition."""
    columns = {k: pd.Series(one) for k, one in enumerate(found)}
    return pd.DataFrame(columns).rename_axis(index=names)


def summary(repeated: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the median of figures that were found repeatedly, and behind all medians the ranges.

    Where one of the repetitions is NaN, as the drive ran away, so is what is returned. The figures
    are by the name of a column, with a column for each repetition; of a single one there is no
    range.
    """
    found = {name: table.median(axis=1, skipna=False) for name, table in repeated.items()}
    for name, table in repeated.items():
        if table.shape[1] > 1:
            found[f"{name}{LOW}"] = table.min(axis=1, skipna=False)
            found[f"{name}{HIGH}"] = table.max(axis=1, skipna=False)
    return pd.DataFrame(found)


def ranges_last(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with the columns of ranges behind all others."""
    return table[sorted(table, key=lambda name: str(name).endswith((LOW, HIGH)))]


PAPER_TABLE4 = {
    ("start", "E_max"): (0.98, 0.76),
    ("start", "E_rms"): (0.86, 0.48),
    ("reverse", "E_max"): (1.76, 0.72),
    ("reverse", "E_rms"): (1.62, 0.44),
}
"""Table 4, without and with compensation; it prints no unit, and mm/s is the reading that fits."""

METRICS = ("E_max", "E_rms")
Errors = TypeVar("Errors", float, pd.Series, pd.DataFrame)

RECORD = (
    *("drive.x_enc", "drive.x", "drive.v", "drive.F_f"),
    *("nominal.v_r", "compensator.F_mean"),
)


@dataclass(frozen=True)
class Run:
    """One motion once."""

    t: Array  # (n,) [s]
    v_cmd: Array  # (n,) [m/s]
    x_enc: Array  # position (n,) [m] that the encoder shows
    v: dict[str, Array]  # (n,) [m/s] by what shows it, ``measured`` and, simulated, ``true``
    v_r: Array  # response of the nominal loop (n,) [m/s]
    F_f: Array  # the drive's true friction (n,) [N]
    F_ff: Array  # the force of the compensator (n,) [N]
    x: Array  # the drive's true position (n,) [m]; NaN where the truth is not known, as F_f

    @property
    def x_cmd(self) -> Array:
        """The position (n,) [m] to which the command leads, from where the run begins."""
        return np.asarray(cumulative_trapezoid(self.v_cmd, self.t, initial=0))


@dataclass(frozen=True, repr=False)
class Validation:
    """Both runs, and the instants at which motion starts and reverses [s]."""

    without: Run
    compensated: Run
    instants: dict[str, float]
    repeated: Sequence[tuple[Run, Run]] = ()  # both runs of further phases

    def errors(self) -> pd.DataFrame:
        """Return velocity errors [mm/s] without and with compensation, and reductions (9).

        A row for each velocity (measured, true), region (start, reverse) and metric: medians over
        the phases, with ranges, and the reduction by the medians.
        """
        regions = regions_after(self.instants)
        both = (self.without, self.compensated), *self.repeated
        names = ["velocity", "region", "metric"]
        before, after = (
            1e3 * repetitions((velocity_errors(run, regions) for run in runs), names)
            for runs in zip(*both, strict=True)
        )
        found = {"without": before, "with": after, "reduction": reduction(before, after)}
        table = summary(found)
        table["reduction"] = reduction(table["without"], table["with"])
        return table.reset_index()

    def table(self) -> pd.DataFrame:
        """Return Table 4: the errors beside those of the paper."""
        table = self.errors()
        paper = [PAPER_TABLE4[key] for key in zip(table["region"], table["metric"], strict=True)]
        table[["paper_without", "paper_with"]] = paper
        table["paper_reduction"] = [reduction(*one) for one in paper]
        return ranges_last(table)

    def __repr__(self) -> str:
        return f"Velocity errors [mm/s]:\n{self.errors().round(3).to_string(index=False)}"

    def _repr_html_(self) -> str:
        return f"<p>Velocity errors [mm/s]</p>{self.errors().round(3).to_html(index=False)}"


def velocity_errors(run: Run, regions: Regions) -> dict[tuple[str, str, str], float]:
    """Return (8a) and (8b) [m/s] by velocity (measured, true), region and metric."""
    return {
        (velocity, region, metric): value
        for velocity, v in run.v.items()
        for region, spans in regions.items()
        for metric, value in tracking_errors(run.t, run.v_cmd - v, spans).items()
    }


def tracking_errors(t: Array, error: Array, spans: Iterable[Span]) -> dict[str, float]:
    """Return (8a) and (8b) of an error (n,) over spans of time [s], their ends included."""
    counted = error[covered(t, spans)]
    return {"E_max": float(np.abs(counted).max()), "E_rms": float(np.sqrt(np.mean(counted**2)))}


def covered(t: Array, spans: Iterable[Span]) -> NDArray[np.bool_]:
    """Return which of the samples (n,) lie within one of the spans of time [s]."""
    half = 0.5 * (t[1] - t[0])
    inside = np.zeros(len(t), dtype=bool)
    for begin, end in spans:
        inside |= (t >= begin - half) & (t <= end + half)
    return inside


def reduction(without: Errors, compensated: Errors) -> Errors:
    """Return the error reduction ratio (9)."""
    return (without - compensated) / without


def validate(
    rig: Rig,
    loop: VelocityLoop,
    compensator: Mapping[str, float],
    command: cosim.Trapezoid,
    plain: VelocityLoop | None = None,  # of the run without compensation, by default ``loop``
    phases: Sequence[float] = ONCE,  # where a simulated drive begins
) -> Validation:
    """Run the trapezoid without and with compensation; raise RigError, or Diverged.

    It may use the true values of a simulated drive, since it evaluates and does not learn. A
    velocity filter that counts on a compensator follows worse without: ``plain`` is the loop that
    it replaces.
    """
    v_cmd = command.sample(rig.samples(trapezoid(command).duration))
    without, compensated = (
        next(runs_of(rig, used, [values], v_cmd, phases=phases))
        for used, values in ((plain or loop, None), (loop, compensator))
    )
    for run in (*without, *compensated):
        for v in run.v.values():
            require_bounded(v, abs(command.height))
    first, *repeated = zip(without, compensated, strict=True)
    return Validation(*first, windows(command), repeated)


def runs_of(
    rig: Rig,
    loop: VelocityLoop,
    compensators: Sequence[Mapping[str, float] | None],  # one that is None, for none, stands alone
    v_cmd: Array,
    phases: Sequence[float] = ONCE,
) -> Iterator[list[Run]]:
    """Run a velocity command (n,) [m/s] with each compensator; a simulated drive at every phase."""
    if not isinstance(rig, FmuRig):
        for compensator in compensators:
            yield [_moved(rig, loop, compensator, v_cmd)]
        return
    connected: dict[str, float] | None = None if compensators[0] is None else {}
    system = paper_loop(rig.fmus, loop, connected)
    stop, commands = (len(v_cmd) - 1) * rig.T_s, loop.commands(v_cmd)
    starts = beginnings(system, phases) if tuple(phases) != ONCE else [{}]
    with system.prepare(step=rig.T_s, stop=stop, record=RECORD) as simulation:
        for compensator in compensators:
            own = {f"compensator.{name}": value for name, value in (compensator or {}).items()}
            runs = []
            for start in starts:
                result = simulation.run({**own, **start}, commands)
                x_enc, x, v, F_f, v_r, F_ff = (result[name] for name in RECORD)
                shown = {"measured": measured_velocity(x_enc, rig.T_s), "true": v}
                runs.append(Run(result.time, v_cmd, x_enc, shown, v_r=v_r, F_f=F_f, F_ff=F_ff, x=x))
            yield runs


def _moved(
    rig: Rig, loop: VelocityLoop, compensator: Mapping[str, float] | None, v_cmd: Array
) -> Run:
    """Run a command on a drive whose truth is not known."""
    with rig.trials(v_cmd, loop, compensated=compensator is not None) as trial:
        found = trial(compensator or {})
    x_enc, unknown = found["drive.x_enc"], np.full(len(v_cmd), np.nan)
    return Run(
        t=rig.samples((len(v_cmd) - 1) * rig.T_s),
        v_cmd=v_cmd,
        x_enc=x_enc,
        v={"measured": measured_velocity(x_enc, rig.T_s)},
        v_r=found["nominal.v_r"],
        F_f=unknown,
        F_ff=found["compensator.F_mean"],
        x=unknown,
    )
