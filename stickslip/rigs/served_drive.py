"""A drive FMU that runs like a drive: sample after sample, with its controller and its limits."""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from stickslip import cosim
from stickslip.cosim.signals.signals import Array
from stickslip.errors import UsageError
from stickslip.rigs.limits import RigLimits, Watch
from stickslip.thresholds import rig_motion

DECELERATION = 2.0  # with which the drive is stopped [m/s^2]
MOST_SAMPLES = 10**9  # of all motions until the server is started again; a week at 2 kHz is more
COMPONENT = "fmu"  # its name in the system of one FMU


def stepped(
    path: Path, T_s: float, inputs: Sequence[str], outputs: Sequence[str]
) -> cosim.Simulation:
    """Return a simulation of one FMU, to be stepped; raise UsageError without such variables."""
    fmu = cosim.Fmu(path, interface="co_simulation")
    for name, kind in (*((n, "input") for n in inputs), *((n, "output") for n in outputs)):
        if name not in fmu.variables or fmu.variables[name].causality != kind:
            raise UsageError(f"{path}: has no {kind} '{name}'")
    system = cosim.System(path.name)
    system.add(COMPONENT, fmu)
    for name in inputs:
        system.expose(name, f"{COMPONENT}.{name}")
    record = cosim.Record([f"{COMPONENT}.{name}" for name in outputs], keep="last")
    return system.prepare(step=T_s, stop=T_s * MOST_SAMPLES, record=record)


@dataclass(frozen=True)
class Ports:
    """Names of the drive FMU's variables: force command, position and motor force."""

    u: str = "u"
    x_enc: str = "x_enc"
    F_m: str = "F_m"


class ServedDrive:
    """A drive with a velocity controller: it runs one motion after the other from where it stands.

    Between motions a brake holds it, and its time stands still.
    """

    def __init__(self, drive: Path, controller: Path, T_s: float, ports: Ports) -> None:
        self.T_s, self._ports = T_s, ports
        self._drive = stepped(drive, T_s, [ports.u], [ports.x_enc, ports.F_m])
        signals = ("v_cmd", "a_cmd", "x_cmd", "F_ff", "x_enc")
        self._controller = stepped(controller, T_s, signals, ["u"])
        self._measured = self._measure(self._drive.start())
        self.state = "idle"  # idle, moving or stopping
        self.motion = 0  # number of the last motion that was started; 0 for none
        self.reason, self.at_limit = "", False  # why it was aborted, and whether by a limit
        self.failed = ""  # why it can run no motion any more
        self.x: list[float] = []  # its positions, one a sample [m]
        self.F: list[float] = []  # its forces [N]

    @property
    def position(self) -> float:
        """What the encoder shows [m]."""
        return self._measured[0]

    def start(
        self,
        motion: int,
        signals: Mapping[str, Array],
        loop: Mapping[str, float],
        limits: RigLimits,
    ) -> None:
        """Begin a motion with parameters of the controller, unless that raises CosimError."""
        self._start_controller(loop)
        self._signals = {name: values.tolist() for name, values in signals.items()}
        self._n = len(next(iter(self._signals.values())))
        self._begin = self.position
        self._loop, self._watch = dict(loop), Watch(limits, self.T_s)
        self._last: deque[float] = deque(maxlen=21)
        self.x, self.F = [], []
        self.state, self.motion, self.reason, self.at_limit = "moving", motion, "", False

    def abort(self, reason: str, *, at_limit: bool = False) -> None:
        """Stop the motion, if there is one."""
        if self.state == "moving":
            self.reason, self.at_limit = reason, at_limit
            self._stop()

    def advance(self) -> None:
        """Run one sample of a motion, or of the stop behind it."""
        self._last.append(self.position)
        if self.state == "moving":
            self._look()
        values = self._next() if self.state == "moving" else self._ramp()
        if self.state == "idle":
            return
        try:
            u = values.get("F")
            if u is None:
                (u,) = self._controller.step({"x_enc": self.position, **values}).values()
            measured = self._measure(self._drive.step({self._ports.u: u}))
        except cosim.CosimError as fault:
            self._fail(str(fault))
            return
        if not all(map(math.isfinite, measured)):
            self._fail(f"position {measured[0]} m, force {measured[1]} N")
            return
        self._measured = measured

    def close(self) -> None:
        """Free the FMUs."""
        self._drive.close()
        self._controller.close()

    def _start_controller(self, loop: Mapping[str, float]) -> None:
        parameters = {f"{COMPONENT}.{name}": x for name, x in {**loop, "T_s": self.T_s}.items()}
        self._controller.start(parameters, {"x_enc": self.position})

    def _measure(self, outputs: Mapping[str, float]) -> tuple[float, float]:
        """Return position and force."""
        x_enc, F_m = (outputs[f"{COMPONENT}.{n}"] for n in (self._ports.x_enc, self._ports.F_m))
        return x_enc, F_m

    def _fail(self, what: str) -> None:
        self.failed = self.reason = f"the drive FMU failed: {what}"
        self.state = "idle"

    def _look(self) -> None:
        """Log a sample, and stop at the end or at a limit."""
        k, (x, F) = len(self.x), self._measured
        self.x.append(x)
        self.F.append(F)
        commanded = self._signals.get("v_cmd")
        if found := self._watch.sample(x, F, commanded[k] if commanded else None):
            self.abort(f"aborted at {k * self.T_s:.4g} s: {found}", at_limit=True)
        elif k == self._n - 1:
            self._stop()

    def _next(self) -> dict[str, float]:
        values = {name: signal[len(self.x) - 1] for name, signal in self._signals.items()}
        if "x_cmd" in values:
            values["x_cmd"] += self._begin
        return values

    def _stop(self) -> None:
        self.state, self._stopping, self._resting = "stopping", 0, 0
        if "F" in self._signals:
            self._start_controller(self._loop)
        self._v, self._x_cmd = self._velocity(), self.position

    def _velocity(self) -> float:
        span = self.T_s * max(1, len(self._last) - 1)
        return (self._last[-1] - self._last[0]) / span if self._last else 0.0

    def _ramp(self) -> dict[str, float]:
        """Return the inputs of the controller while the drive is stopped."""
        change = DECELERATION * self.T_s
        self._v = max(0.0, abs(self._v) - change) * (1.0 if self._v > 0 else -1.0)
        self._x_cmd += self.T_s * self._v
        self._stopping += 1
        rest = self._v == 0.0 and abs(self._velocity()) < rig_motion.AT_REST
        self._resting = self._resting + 1 if rest else 0
        resting, stopping = self._resting * self.T_s, self._stopping * self.T_s
        if resting >= rig_motion.SETTLED or stopping >= rig_motion.LONGEST_STOP:
            self.state = "idle"
        return {"v_cmd": self._v, "a_cmd": 0.0, "x_cmd": self._x_cmd, "F_ff": 0.0}
