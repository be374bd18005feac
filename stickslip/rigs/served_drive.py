"""A drive FMU that runs like a drive: sample after sample, with its controller and its limits."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from stickslip import cosim
from stickslip.cosim.signals.signals import Array
from stickslip.errors import UsageError
from stickslip.fmucheck.description.reading import read_description
from stickslip.fmucheck.document import read_document
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.rigs.limits import RigLimits, Watch

DECELERATION = 2.0
"""With which the drive is stopped [m/s^2]."""
SETTLE, LONGEST_STOP = 0.1, 3.0
"""Time at rest before the brake holds, and after which it does in any case [s]."""
AT_REST = 1e-3
"""Speed that counts as rest [m/s]."""


class Stepper:
    """One FMU for Co-Simulation, stepped a sample at a time.

    Raises
    ------
    UsageError
        When it has no such inputs or outputs.
    """

    def __init__(self, path: Path, T_s: float, inputs: Sequence[str], outputs: Sequence[str]):
        fmu = cosim.Fmu(path, interface="co_simulation")
        content = (fmu.folder / "modelDescription.xml").read_bytes()
        root = read_document(path.name, content).root
        description = read_description(root, fmu.version) if root is not None else None
        interface = description.interface("CoSimulation") if description else None
        if description is None or interface is None:
            raise UsageError(f"{path}: expected an FMU for Co-Simulation")
        self._bench = Bench(description, interface, fmu.binary, fmu.folder / "resources", before=[])
        self._variables = {variable.name: variable for variable in description.variables}
        for name, kind in (*((n, "input") for n in inputs), *((n, "output") for n in outputs)):
            if name not in fmu.variables or fmu.variables[name].causality != kind:
                raise UsageError(f"{path}: has no {kind} '{name}'")
        self._outputs = [self._variables[name] for name in outputs]
        self._T_s = T_s

    def begin(self, **values: float) -> list[float]:
        """Take a new instance with start values; return the outputs."""
        self._bench.close()
        self._instance, self._n = self._bench.new(), 0
        self._set(values)
        self._instance.enter_initialisation(0.0)
        self._set({n: v for n, v in values.items() if self._variables[n].causality == "input"})
        self._instance.exit_initialisation()
        if self._instance.event_mode:
            self._instance.leave_event_mode()
        return self._get()

    def step(self, **inputs: float) -> list[float]:
        """Set inputs, step over one sample period, and return the outputs."""
        self._set(inputs)
        begin, end = self._n * self._T_s, (self._n + 1) * self._T_s
        self._instance.step(begin, end - begin)
        self._n += 1
        return self._get()

    def close(self) -> None:
        """Free the instance."""
        self._bench.close()

    def _set(self, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            self._instance.set(self._variables[name], (value,))

    def _get(self) -> list[float]:
        return [float(value) for (value,) in self._instance.get(self._outputs)]


@dataclass(frozen=True)
class Ports:
    """Names of the drive FMU's variables: force command, position and motor force."""

    u: str = "u"
    x_enc: str = "x_enc"
    F_m: str = "F_m"


class ServedDrive:
    """A drive with a velocity controller: it runs one motion after the other from where it stands.

    Between motions a brake holds it, and its time stands still.

    Attributes
    ----------
    state : idle, moving or stopping
    motion : number of the last motion that was started; 0 for none
    x, F : log of that motion, a value each sample [m], [N]
    reason : why that motion was aborted, or empty
    at_limit : whether a limit aborted it
    failed : why it can run no motion any more, or empty
    """

    def __init__(self, drive: Path, controller: Path, T_s: float, ports: Ports) -> None:
        self.T_s, self._ports = T_s, ports
        self._drive = Stepper(drive, T_s, [ports.u], [ports.x_enc, ports.F_m])
        signals = ("v_cmd", "a_cmd", "x_cmd", "F_ff", "x_enc")
        self._controller = Stepper(controller, T_s, signals, ["u"])
        self._measured = self._drive.begin()
        self.state, self.motion, self.reason, self.at_limit = "idle", 0, "", False
        self.failed = ""
        self.x: list[float] = []
        self.F: list[float] = []

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
        """Begin a motion, with signals of a ``Command`` and parameters of the controller.

        Raises
        ------
        CallFailed
            When the controller does not take its parameters; then nothing has begun.
        """
        self._controller.begin(T_s=self.T_s, x_enc=self.position, **loop)
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
                (u,) = self._controller.step(x_enc=self.position, **values)
            measured = self._drive.step(**{self._ports.u: u})
        except CallFailed as fault:
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
            self._controller.begin(T_s=self.T_s, x_enc=self.position, **self._loop)
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
        rest = self._v == 0.0 and abs(self._velocity()) < AT_REST
        self._resting = self._resting + 1 if rest else 0
        if self._resting * self.T_s >= SETTLE or self._stopping * self.T_s >= LONGEST_STOP:
            self.state = "idle"
        return {"v_cmd": self._v, "a_cmd": 0.0, "x_cmd": self._x_cmd, "F_ff": 0.0}
