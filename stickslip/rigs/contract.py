"""The contract of a rig: a drive, real or simulated, that runs commands and returns logs.

Identification and learning get a rig, never the drive's parameters or its true motion.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd

from stickslip import cosim
from stickslip.catalog.parameters import friction_law
from stickslip.errors import LimitError, RigError, UsageError
from stickslip.fmi.process import temporary_folder
from stickslip.rigs.limits import RigLimits, Watch
from stickslip.servo.axis import Datasheet, LoopSpecification
from stickslip.servo.measurement import Array
from stickslip.servo.systems import build_fmus, feedforward
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop
from stickslip.thresholds import rig_motion

COMMISSIONING = LoopSpecification(bandwidth=50.0, phase_margin=60.0, T_s=5e-4, tau_f=5e-4)
"""The loop of a recording: soft, so that it bears a third and three times its nominal mass."""


def _values(what: str, given: object) -> Array:
    """Return numbers as an array (n,)."""
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.empty((0, 0))
    if values.ndim != 1 or not len(values):
        raise UsageError(f"{what}: expected numbers (n,), got {' '.join(str(given).split())[:80]}")
    return values


@dataclass(frozen=True)
class Command:
    """One motion, a value each sample; it has a velocity or a force.

    Attributes
    ----------
    T_s : sample period [s]
    loop : gains of the velocity loop; a motion with a force uses it only to stop
    velocity : (n,) to be followed in that loop [m/s]
    added_force : (n,) added to the output of that loop, such as a compensator's [N]
    force : (n,) of the motor, without any loop [N]

    Raises
    ------
    UsageError
        When T_s is not above 0, or it has velocity and force, or neither, or values that are not
        finite numbers or not n.
    """

    T_s: float
    loop: VelocityLoop
    velocity: Array | None = None
    added_force: Array | None = None
    force: Array | None = None

    def __post_init__(self) -> None:
        if (self.velocity is None) == (self.force is None):
            raise UsageError("a command has a velocity or a force; expected one of them")
        if not 0.0 < self.T_s < np.inf:
            raise UsageError(f"command: T_s = {self.T_s} s; expected more than 0")
        for name in ("velocity", "added_force", "force"):
            values = getattr(self, name)
            if values is not None:
                object.__setattr__(self, name, _values(f"command: {name}", values))
        for name, values in self.signals.items():
            if len(values) != len(self) or not np.isfinite(values).all():
                raise UsageError(f"command: {name} has not {len(self)} finite values")

    def __len__(self) -> int:
        driven = self.force if self.velocity is None else self.velocity
        return 0 if driven is None else len(driven)

    @property
    def signals(self) -> dict[str, Array]:
        """What the drive takes by name, (n,) each: F, or v_cmd, a_cmd, x_cmd and F_ff in use."""
        if self.velocity is None:
            return {} if self.force is None else {"F": self.force}
        added = {} if self.added_force is None else {"F_ff": self.added_force}
        return {**self.loop.commands(self.velocity), **added}


@dataclass(frozen=True)
class Log:
    """One recording, a value each sample.

    Attributes
    ----------
    t : (n,) [s]
    x_enc : (n,) position shown by the encoder, from where motions begin [m]
    F_m : (n,) motor force, from the current [N]

    Raises
    ------
    UsageError
        When they are not numbers, or not equally many.
    """

    t: Array
    x_enc: Array
    F_m: Array

    def __post_init__(self) -> None:
        for name in ("t", "x_enc", "F_m"):
            object.__setattr__(self, name, _values(f"log: {name}", getattr(self, name)))
        if not len(self.t) == len(self.x_enc) == len(self.F_m):
            sizes = f"{len(self.t)}, {len(self.x_enc)} and {len(self.F_m)}"
            raise UsageError(f"log: t, x_enc and F_m have {sizes} values; expected equally many")

    def table(self) -> pd.DataFrame:
        """Return time [s], position [m] and force [N], as a log is read by ``stickslip learn``."""
        return pd.DataFrame({"time": self.t, "position": self.x_enc, "force": self.F_m})


def commissioning_loop(sheet: Datasheet, T_s: float = COMMISSIONING.T_s) -> VelocityLoop:
    """Return the loop of a recording, for the mass of the datasheet."""
    return design_velocity_loop(sheet.axis(sheet.mass, 0.0), replace(COMMISSIONING, T_s=T_s))


def refuse(limits: RigLimits, command: Command) -> None:
    """Check a command before anything moves; raise LimitError where it exceeds a limit."""
    watch = Watch(limits, command.T_s)
    driven = command.added_force if command.force is None else command.force
    checks = {} if driven is None else {"force": driven}
    if command.velocity is not None:
        checks["speed"] = command.velocity
        checks["position"] = command.T_s * np.concatenate([[0.0], np.cumsum(command.velocity)])
    for what, values in checks.items():
        for value in (float(values.max()), float(values.min())):
            if found := watch.exceeded(what, value):
                raise LimitError(f"the command exceeds a limit, nothing has moved: {found}")


TrialLog = cosim.Result | Mapping[str, Array]
"""What a trial recorded: signals (n,) by name."""


def _wrong_log(log: object, command: Command) -> str:
    """Return what is wrong with the log of a command, or an empty text."""
    if not isinstance(log, Log):
        return f"move returned a {type(log).__name__}; expected ss.Log"
    n, T_s = len(command), command.T_s
    if len(log.t) != n:
        return f"a log of {len(log.t)} samples; expected {n}, as many as the command has"
    for name in ("t", "x_enc", "F_m"):
        values = getattr(log, name)
        if not np.isfinite(values).all():
            k = int(np.argmin(np.isfinite(values)))
            return f"{name} of the log is {values[k]} in sample {k}; expected finite values"
    if n == 1:
        return ""
    steps, spacing = np.diff(log.t), (log.t[-1] - log.t[0]) / (n - 1)
    if not steps.min() > 0.0:
        k = int(np.argmin(steps)) + 1
        return f"t of the log does not rise at sample {k}, {log.t[k]:.6g} s; expected rising times"
    if abs(spacing - T_s) > rig_motion.SPACING * T_s:
        return (
            f"t of the log has a spacing of {spacing:.6g} s; expected T_s = {T_s:.6g} s, as the "
            "command has. Give times in seconds"
        )
    return ""


Trial = Callable[[Mapping[str, float]], TrialLog]  # runs compensator parameters on the drive


class Rig(ABC):
    """A drive on its test bench: it takes commands and returns measurements.

    A kind of rig implements ``move``. It is used in a ``with`` block, and the drive is stopped when
    that is left.

    Parameters
    ----------
    datasheet : what is known of the drive
    T_s : sample period of commands and logs [s]
    limits : that abort a motion; None only where nothing can be damaged
    law : friction law of the compensator

    Attributes
    ----------
    name : display name

    Raises
    ------
    UsageError
        When T_s is not a finite number above 0.
    """

    name = "drive"

    def __init__(
        self, datasheet: Datasheet, T_s: float, limits: RigLimits | None, law: str = "lugre"
    ) -> None:
        if not 0.0 < T_s < np.inf:
            raise UsageError(f"{self.name}: T_s = {T_s} s; expected a finite number above 0")
        self.datasheet = datasheet
        self.T_s = T_s
        self._runs = 0
        self.limits = limits
        self.law = friction_law(law)
        self._closing = ExitStack()

    @abstractmethod
    def move(self, command: Command) -> Log:
        """Run a motion that begins at rest at position 0, bring the drive to rest, return its log.

        The drive has to be stopped when this raises anything, and when this program ends. A motion
        whose log is lost is not repeated.

        Raises
        ------
        LimitError
            When a limit aborted the motion.
        RigError
            When the motion did not end as commanded, or it is not known how it ended.
        """

    def run(self, command: Command) -> Log:
        """Run a motion within the limits and return its log, n values each.

        Raises what ``move`` does; also LimitError when the command exceeds a limit, before anything
        moves, and RigError when the log is not one of this command.
        """
        if self.limits is not None:
            refuse(self.limits, command)
        self._runs += 1
        try:
            log = self.move(command)
        except (RigError, cosim.CosimError):
            raise
        except Exception as fault:
            what = " ".join(f"{type(fault).__name__}: {fault}".split())
            raise RigError(
                f"{self.name}: motion {self._runs}: {what}; expected a log from move. Look at the "
                "drive before going on"
            ) from fault
        if wrong := _wrong_log(log, command):
            raise RigError(f"{self.name}: motion {self._runs}: {wrong}")
        if self.limits is None:
            return log
        watch, velocity = Watch(self.limits, self.T_s), command.velocity
        commanded = [None] * len(command) if velocity is None else velocity.tolist()
        samples = zip(log.t, log.x_enc.tolist(), log.F_m.tolist(), commanded, strict=True)
        for t, x, F, v_cmd in samples:
            if found := watch.sample(x, F, v_cmd):
                raise LimitError(f"the motion was aborted at {t:.4g} s: {found}")
        return log

    @property
    def bounds(self) -> RigLimits | None:
        """The limits that a motion must keep."""
        return self.limits

    @property
    def loop(self) -> VelocityLoop:
        """The loop in which the drive is recorded; a soft one for the mass of the datasheet."""
        return commissioning_loop(self.datasheet, self.T_s)

    def push(self, force: Array) -> Log:
        """Command a force (n,) [N], one value a sample, without any loop."""
        return self.run(Command(self.T_s, self.loop, force=force))

    def follow(self, v_cmd: Array, loop: VelocityLoop) -> Log:
        """Command a velocity (n,) [m/s], one value a sample, in a velocity loop."""
        return self.run(Command(self.T_s, loop, velocity=v_cmd))

    def samples(self, duration: float) -> Array:
        """Return the sample instants (n,) of a recording [s]."""
        return np.asarray(np.arange(round(duration / self.T_s) + 1) * self.T_s)

    @cached_property
    def fmus(self) -> Path:
        """The folder of the FMUs that compute what is sent to the drive; it goes with the rig."""
        folder = self._closing.enter_context(temporary_folder())
        build_fmus(folder, {}, self.law.name)
        return folder

    @contextmanager
    def trials(
        self, v_cmd: Array, loop: VelocityLoop, *, compensated: bool = True
    ) -> Iterator[Trial]:
        """Return what runs a velocity command (n,) [m/s] with compensators on the drive: Fig. 3.

        A trial takes parameters of the compensator by name; it records ``drive.x_enc`` and
        ``nominal.v_r``. The compensator depends on the command only, so that its force
        ``compensator.F_mean`` is known before the motion.

        Parameters
        ----------
        compensated : whether the compensator's force reaches the drive
        """
        simulated = self.limits is None  # else each sample has to be compared with them
        whole = self._simulated(v_cmd, loop, compensated=compensated) if simulated else None
        record = ("nominal.v_r", "compensator.F_mean")
        specification = whole or cosim.Specification(
            feedforward(self.fmus, loop, {}),
            step=self.T_s,
            stop=(len(v_cmd) - 1) * self.T_s,
            record=record,
        )
        with specification.prepare() as simulation:

            def run(values: Mapping[str, float]) -> TrialLog:
                named = {f"compensator.{name}": value for name, value in values.items()}
                computed = simulation.run(named, loop.commands(v_cmd))
                if whole:
                    return computed
                force = computed["compensator.F_mean"]
                # The force of row n + 1 acts from t[n] on.
                added = np.append(force[1:], force[-1]) if compensated else None
                log = self.run(Command(self.T_s, loop, velocity=v_cmd, added_force=added))
                return {"drive.x_enc": log.x_enc, **{name: computed[name] for name in record}}

            yield run

    def _simulated(
        self, v_cmd: Array, loop: VelocityLoop, *, compensated: bool
    ) -> cosim.Specification | None:
        """Return a run of drive and compensator, connected or not; None of a real drive."""
        del v_cmd, loop, compensated
        return None

    def close(self) -> None:
        """Let go of the drive, which is at rest."""
        self._closing.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
