"""From a log's file to a recording."""

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from stickslip.errors import RecordingError, UsageError
from stickslip.logs.channels import Channel, assumed_units, motion_from, signal_of, unit_fault
from stickslip.logs.description import ROLES, Controller, Description, Product
from stickslip.logs.formats import read_table
from stickslip.logs.grid import even_grid
from stickslip.logs.recording import Finding, Motion, Recording
from stickslip.logs.roles import assign_roles, named_quantity
from stickslip.logs.sampling import even_rows, on_one_clock, step_of
from stickslip.logs.table import LogTable, with_joined_times
from stickslip.logs.units import Unit, described_ratio, near_factor, sized_unit
from stickslip.servo.measurement import Array, derivative
from stickslip.thresholds import log_unit

MOST_FEEDFORWARD = 2.0  # largest velocity feedforward of a cascade, a share of the velocity command


@dataclass(frozen=True)
class Reading:
    """A log, read and converted to SI units."""

    recording: Recording  # its signals in SI units on an even grid
    controller: Controller  # that was in use; kind none when it is not known
    findings: tuple[Finding, ...] = ()  # what was detected, filled in or cut off
    force_limit: float | None = None  # of motor, amplifier or controller [N], None if unknown
    tau_i: float | None = None  # time constant of the amplifier's current loop [s], if known
    channels: tuple[Channel, ...] = ()  # its columns in their roles, without those in error
    description: Description = field(default_factory=Description)  # by which it was read

    @property
    def units(self) -> dict[str, Unit | None]:
        """Units of the columns by role, None where none is stated."""
        return {one.role: one.unit for one in self.channels}

    @property
    def timed(self) -> bool:
        """Whether the time between its samples is in a unit that is known or assumed."""
        return "time" in self.units or self.description.sample_period is not None

    @property
    def assumed(self) -> tuple[str, ...]:
        """Roles whose numbers are assumed to be in SI units, because no unit or scale is stated."""
        return tuple(c.role for c in self.channels if c.unit is None and c.scale is None)


def raise_errors(path: str | os.PathLike[str], findings: Iterable[Finding]) -> None:
    """Raise the first finding that is an error; raise RecordingError when there is one."""
    for finding in findings:
        if finding.severity == "error":
            raise RecordingError(f"{path}: {finding}")


def read_recording(
    path: str | os.PathLike[str],
    description: Description | None = None,
    *,
    strict: bool = True,
    commands: bool = False,
) -> Reading:
    """Read a log: CSV and its relatives, or one of ``formats``.

    What the description leaves open is detected and reported. Unless ``strict``, a column whose
    unit is wrong or missing is an error among the findings, and its numbers are kept as they are.
    With ``commands`` those of a motion are enough.
    Raises RecordingError when the file cannot become a recording; names row or column, or
    UsageError when the description does not suit it.
    """
    given = description or Description()
    table = with_joined_times(read_table(Path(path), given.delimiter, given.decimal))
    roles, detected = assign_roles(table, given)
    _check_roles(table, roles, given, commands=commands)
    channels = [Channel.of(table, given, role, roles[role]) for role in ROLES if role in roles]
    motion, reasons = motion_from(given, channels)
    _check_rated(given, motion)
    findings = [*table.findings, *detected, *reasons]
    if given.sample_period and channels[0].role == "time":
        findings.append(_unused_time(table, given.sample_period, channels.pop(0)))
    faults = {
        one.role: fault for one in channels if (fault := unit_fault(table, given, one, motion))
    }
    signals = {one.role: signal_of(table, one) for one in channels}
    findings += [*faults.values(), *assumed_units(channels, motion)]
    n = len(next(iter(signals.values())))
    for role, signal in signals.items():  # the columns of a MAT file may differ
        if len(signal) != n:
            raise RecordingError(
                f"{table.path}: '{roles[role]}' ({role}) has {len(signal)} values; expected {n}, "
                f"as '{roles[next(iter(signals))]}' has"
            )
    if given.sample_period:
        stamps = table.numbers.get(roles.get("time", ""), np.arange(n, dtype=np.float64))
        rows = even_rows(table, stamps, signals, findings)
        signals = {role: signal[rows] for role, signal in signals.items()}
        signals["time"] = given.sample_period * np.arange(len(rows), dtype=np.float64)
        table = table.part(rows)
    table = replace(table, numbers={})  # a long log takes much memory
    t = signals.pop("time")
    if given.span:
        t, signals, table = _cut(table, t, signals, given.span)
    step = _encoder_step(table, given.encoder_step, signals, findings)
    rows, t, signals = on_one_clock(table, t, signals, findings)
    t, even, done = even_grid(table.part(rows), t, signals, motion)
    findings += [*done, *_integrated(given, signals)]
    if strict:
        raise_errors(table.path, findings)
    name = Path(path).name
    recording = Recording(t, **even, encoder_step=step, motion=motion, source=name, segments=())
    gains = {name: table.value(value, f"gain {name}") for name, value in given.gains.items()}
    for name, value in gains.items():
        if value < 0:
            raise UsageError(f"controller: {name} = {value:g}: expected 0 or more")
        if name == "velocity_feedforward" and value > MOST_FEEDFORWARD:
            expected = f"0 to {MOST_FEEDFORWARD:g}; 100 % are 1"
            raise UsageError(f"controller: {name} = {value:g}: expected {expected}")
    controller = Controller(given.controller, **gains)
    commanded, controller = with_velocity_command(recording, controller)
    if commanded is not recording:
        what = "no velocity command was logged, but the cascade has velocity feedforward"
        findings.append(Finding("note", what, advice="the position command is differentiated"))
    limit = _positive(table, given.force_limit, "force_limit")
    if limit is None and math.isfinite(controller.u_max):
        limit = controller.u_max
    return Reading(
        commanded,
        controller,
        tuple(findings),
        limit,
        tau_i=given.tau_i,
        channels=tuple(one for one in channels if one.role not in faults),
        description=given,
    )


def with_velocity_command(
    recording: Recording, controller: Controller
) -> tuple[Recording, Controller]:
    """Return a recording with the velocity command that a cascade follows, and its share of it.

    A velocity command that was not logged is the derivative of the position command, where the
    controller has velocity feedforward.
    """
    if not controller.K_x:
        return recording, controller
    x_cmd, share = recording.position_command, controller.velocity_feedforward
    if share is None:
        share = 0.0 if recording.velocity_command is None else 1.0
    if share and recording.velocity_command is None and x_cmd is not None:
        recording = replace(recording, velocity_command=derivative(x_cmd, recording.T_s))
    return recording, replace(controller, velocity_feedforward=share)


def _check_roles(
    table: LogTable, roles: dict[str, str], given: Description, *, commands: bool
) -> None:
    """Check that there is a time and a motion, or its command."""
    motions = ["position", "velocity", *(("position_command", "velocity_command") * commands)]
    if "time" not in roles and not given.sample_period:
        missing, advice = "time", "<column time=NAME> or <sample_period>"
    elif not {*motions} & set(roles):
        missing, advice = " or ".join(motions), f"<column {motions[-1 if commands else 0]}=NAME>"
    else:
        return
    names = ", ".join(table.names[:12])
    raise RecordingError(
        f"{table.path}: no column of {missing}; give {advice}, the columns are {names}"
    )


def _check_rated(given: Description, motion: Motion) -> None:
    """Check that what 100 % stand for is a force of a linear drive, or a torque of a rotary one."""
    wrong, right = ("torque", "force") if motion == "linear" else ("force", "torque")
    if getattr(given, f"rated_{wrong}") is not None:
        raise UsageError(
            f"<rated_{wrong}>: the motion is {motion}; give <rated_{right}>, or another <motion>"
        )


def _unused_time(table: LogTable, period: float, time: Channel) -> Finding:
    """Return the finding on a column of time where the sample period [s] is given."""
    name, unit = time.source, time.unit
    counts = unit.quantity == "number" if unit else named_quantity(name) == "number"
    if name in table.numbers and name not in table.faults and not counts:
        t = signal_of(table, time)
        t = t[np.isfinite(t)]
        spacing = float(np.ptp(t)) / (len(t) - 1) if len(t) > 1 else 0.0
        if spacing and not 1 / log_unit.EQUALS < spacing / period < log_unit.EQUALS:
            what = "the column of time and <sample_period> contradict each other"
            ratio = described_ratio(spacing / period)
            figure = f"{spacing:.4g} s and {period:.4g} s a row, a factor of {ratio}"
            advice = f"<sample_period> is in s, not a rate; give <sample_period {spacing:.6g}>"
            factor = near_factor(spacing / period)
            other = sized_unit(["time"], 1 / factor[0]) if factor else None
            option = f", <unit time={other.name}> without <sample_period>" if other else ""
            return Finding("error", what, figure, f"{advice}{option}, or <column time=none>")
    what = f"the sample period is used instead of column '{name}'"
    return Finding("note", what, f"{period:g} s")


def _cut(
    table: LogTable, t: Array, signals: dict[str, Array], span: tuple[float, float]
) -> tuple[Array, dict[str, Array], LogTable]:
    """Return what lies in a span of time [s], and a table with the rows of it."""
    kept = np.flatnonzero((t >= span[0]) & (t <= span[1]))
    if not len(kept):
        finite = t[np.isfinite(t)]
        has = f"{finite.min():.6g} to {finite.max():.6g} s" if len(finite) else "no times"
        raise UsageError(f"span {span[0]:g} to {span[1]:g} s: no samples there; the log has {has}")
    return t[kept], {role: signal[kept] for role, signal in signals.items()}, table.part(kept)


def _integrated(given: Description, signals: dict[str, Array]) -> list[Finding]:
    """Return what to know of a position that is the integral of the velocity."""
    if "position" in signals or "velocity" not in signals:
        return []
    needs = Controller(given.controller, **dict.fromkeys(given.gains, 1.0)).needs
    if needs == "position_command":
        what = "a controller of position, but only the velocity was logged"
        return [Finding("error", what, advice="log the position; its constant is unknown")]
    what = "the position is integrated from the velocity"
    return [Finding("note", what, "its constant is unknown, it begins at 0")]


def _encoder_step(
    table: LogTable, given_as: Product | None, signals: dict[str, Array], findings: list[Finding]
) -> float:
    """Return the resolution that was given, else the one that the positions show."""
    shown = step_of(signals["position"]) if "position" in signals else 0.0
    given = _positive(table, given_as, "encoder_step")
    if given is None:
        return shown
    factor = near_factor(shown / given) if shown else None
    if factor and not 1 < factor[0] < 1e3:  # a log may have fewer digits than the encoder
        what = "the steps of the position and <encoder_step> contradict each other"
        figure = f"{shown:.4g} and {given:.4g}, a factor near {factor[1]}"
        advice = "correct <encoder_step> or the unit of the position, <unit position=UNIT>"
        findings.append(Finding("error", what, figure, advice))
    elif shown and abs(shown / given - max(1, round(shown / given))) > log_unit.STEP:
        figure = f"{given:.4g} given, {shown:.4g} found"
        advice = "check scale and unit of the position"
        findings.append(Finding("warning", "the position moves in other steps", figure, advice))
    return given


def _positive(table: LogTable, given_as: Product | None, what: str) -> float | None:
    if given_as is None:
        return None
    value = table.value(given_as, what)
    if value <= 0:
        raise UsageError(f"{what} = {value:g}: expected more than 0")
    return value
