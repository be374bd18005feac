"""The loop with a known controller: controller FMU, drive FMU, and the recorded commands.

The drive FMU represents the candidate: each estimated parameter is set, and its converter and
encoder are off unless the recording is simulated again with them.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from stickslip import cosim
from stickslip.catalog.parameters import ParameterSpace, Values, friction_law
from stickslip.identification.criteria.motion import measured_force, position_noise, position_of
from stickslip.identification.criteria.runs import (
    Closing,
    Criterion,
    Recent,
    Runs,
    require_bounded,
    together,
)
from stickslip.logs import Recording
from stickslip.models import Law
from stickslip.servo.lanes import Run
from stickslip.servo.measurement import Array

HELD, FADING = "F_held", "F_fading"  # forces that the log began with, beside the gains [N]


def initial_state(missing: Array, gains: Mapping[str, float], T_s: float) -> dict[str, float]:
    """Return what suits best a force (n,) [N] that a controller with empty memory lacks.

    Its integrals held a force then, and its low-pass a velocity. Both add to what it commands along
    the log: the one stays, the other fades with tau_f.
    """
    columns = np.column_stack([np.ones_like(missing), _fading(len(missing), gains, T_s)])
    held, fading = np.linalg.lstsq(columns, missing, rcond=None)[0]
    return {HELD: float(held), FADING: float(fading)}


def is_running(gains: Mapping[str, float]) -> bool:
    """Tell whether the log began with something in the controller's memory."""
    return HELD in gains


def memory_force(gains: Mapping[str, float], n: int, T_s: float) -> Array:
    """Return what the memory adds along the log (n,) [N]."""
    held, fading = gains.get(HELD, 0.0), gains.get(FADING, 0.0)
    return held + fading * _fading(n, gains, T_s)


def fmu_gains(gains: Mapping[str, float]) -> dict[str, float]:
    """Return what the controller FMU has a parameter for."""
    return {name: value for name, value in gains.items() if name not in (HELD, FADING)}


def _fading(n: int, gains: Mapping[str, float], T_s: float) -> Array:
    tau_f, T_s = gains.get("tau_f", 0.0), gains.get("T_s", T_s)
    fading: Array = np.exp(-T_s / max(tau_f, 1e-3 * T_s) * np.arange(n))
    return fading


SHORTEST_LAG = 1e-7  # that the drive FMU takes [s]
NO_LIMIT = 1e9  # [N]
FEW = 11  # samples from which the first velocity is estimated
STATES: dict[str, Callable[[float, Values], float]] = {
    "z": lambda force, values: force / values["sigma_0"],
    "F_d": lambda force, _: force,
}
"""State of a friction law -> its value at rest under a force [N]. Other states start at 0."""

NOTHING: Mapping[str, float] = {}
Signals = cosim.Result | Mapping[str, Array]
"""What a run recorded (n,), by name."""


class Point(NamedTuple):
    """What a run is made with."""

    values: Values  # in the drive
    further: Mapping[str, float] = NOTHING  # of this run only, as ``candidate.noise_x``
    feedforward: Array | float = 0.0  # (n,) force of a compensator from each sample on [N]
    offset: float = 0.0  # by which the drive, and so the encoder's steps, are displaced [m]


class KnownLoop(Closing):
    """Simulates the experiment of a recording, each of its logs with the gains of that."""

    def __init__(
        self,
        fmus: Path,  # folder of the FMUs
        recording: Recording,  # gives commands, start and encoder
        gains: Mapping[str, float],  # of the controller FMU; its initial state, if it was running
        *,
        # whether the position is quantised; the trajectory is then not a smooth function of the
        # parameters
        encoder: bool = False,
        workers: int = 1,  # number of parallel runs
    ) -> None:
        self._recording, self._speed = recording, _top_speed(recording)
        self._logs = [
            _LogLoop(
                *(fmus, recording.log(one), one.gains or gains),
                encoder=encoder,
                workers=workers,
                load=one.load,
            )
            for one in recording.pieces
        ]
        self.held = self._logs

    def run(
        self,
        values: Values,
        further: Mapping[str, float] = NOTHING,
        feedforward: Array | float = 0.0,
    ) -> Signals:
        """Run the experiment of a ``Point``; return signals (n,) by name."""
        return self.results([Point(values, further, feedforward)])[0]

    def results(self, points: Sequence[Point]) -> list[Signals]:
        """Return what ``run`` does of each point; they are run side by side."""
        found = [one.runs.results([one.arguments(at) for at in points]) for one in self._logs]
        if len(self._logs) == 1:
            return list(found[0])
        return [self._joined(runs) for runs in zip(*found, strict=True)]

    def _joined(self, runs: Sequence[cosim.Result]) -> Mapping[str, Array]:
        """Return the signals (n,) by name of all logs, between which they are the recorded ones."""
        recording = self._recording
        place, force = position_of(recording), recording.force
        rest = np.zeros_like(place) if force is None else measured_force(recording)
        at = {"candidate.x": place, "candidate.x_enc": place, "candidate.v": np.zeros_like(place)}
        found = {name: at.get(name, rest).copy() for name in SIGNALS}
        for one, run in zip(recording.pieces, runs, strict=True):
            for name, signal in found.items():
                signal[one.begin : one.end] = run[name]
        return found

    def bounded(
        self,
        values: Values,
        further: Mapping[str, float] = NOTHING,
        feedforward: Array | float = 0.0,
    ) -> Signals:
        """Do what ``run`` does; raise Diverged when the drive runs away from its command."""
        result = self.run(values, further, feedforward)
        require_bounded(result["candidate.v"], self._speed)
        return result


SIGNALS = ("candidate.x", "candidate.v", "candidate.x_enc", "candidate.F_m", "controller.u")
"""What is recorded of a run."""


class _LogLoop(Closing):
    """The experiment of one log."""

    def __init__(
        self,
        fmus: Path,
        recording: Recording,
        gains: Mapping[str, float],
        *,
        encoder: bool,
        workers: int,
        load: float = 0.0,
    ) -> None:
        position = position_of(recording)
        few = position[:FEW]
        parabola = np.polyfit(np.arange(len(few)) * recording.T_s, few, 2)
        start = {"x": position[0], "v": float(parabola[1])}
        self._start, self._load = position[0], load
        limits = {"u_max": NO_LIMIT, "T_s": recording.T_s}
        system = cosim.System("known_loop")
        system.add("controller", fmus / "velocity_controller.fmu", {**limits, **fmu_gains(gains)})
        step = recording.encoder_step
        optics: dict[str, object] = {"encoder": False}
        if encoder:
            optics = {"encoder": step > 0.0, "noise": True, "noise_F": 0.0}
            if step > 0.0:
                optics["encoder_step"] = step
        system.add(
            "candidate", fmus / "drive.fmu", {"dac": False, "u_max": NO_LIMIT, **optics, **start}
        )
        system.connect("controller.u", "candidate.u")
        system.connect("candidate.x_enc", "controller.x_enc")
        self._inputs = {"F_ff": np.zeros_like(recording.t), **recording.controller_inputs}
        for name in self._inputs:
            system.expose(name, f"controller.{name}")
        specification = cosim.Specification(
            system, step=recording.T_s, stop=(len(recording.t) - 1) * recording.T_s, record=SIGNALS
        )
        self.runs = Runs(specification, workers)
        self.held = [self.runs]
        self._added = memory_force(gains, len(recording.t), recording.T_s)
        if recording.known_force is not None:
            self._added -= recording.known_force
        force = recording.force if is_running(gains) else None
        self._first = None if force is None else float(measured_force(recording)[0])
        self._states = cosim.Fmu(fmus / "drive.fmu").variables.keys()

    def arguments(self, point: Point) -> Run:
        """Return the run of a point."""
        values, offset = point.values, point.offset
        parameters = {**candidate(values), **point.further}
        parameters["candidate.m"] += self._load
        if offset:
            parameters["candidate.x"] = self._start + offset
        if self._first is not None:  # friction balances the motor force
            held = float(np.clip(self._first - values["F_0"], -values["F_c"], values["F_c"]))
            for name, state in STATES.items():
                if name in self._states:
                    parameters[f"candidate.{name}"] = state(held, values)
        F_ff = self._inputs["F_ff"] + self._added - values["F_0"] + point.feedforward
        return Run(parameters, {**self._inputs, "F_ff": F_ff})


def _top_speed(recording: Recording) -> float:
    """Return the largest speed of the commands and of the motion [m/s]."""
    places = (position_of(recording), recording.position_command)
    rates = [np.diff(place) / recording.T_s for place in places if place is not None]
    if "v_cmd" in recording.controller_inputs:
        rates.append(recording.controller_inputs["v_cmd"])
    return max(float(np.max(np.abs(rate))) for rate in rates)


def candidate(values: Values) -> dict[str, float]:
    """Return the drive FMU's parameters for values by name."""
    elsewhere = ("F_0", "delay")
    parameters = {f"candidate.{n}": value for n, value in values.items() if n not in elsewhere}
    parameters["candidate.b"] = max(values["b"], 0.0)
    parameters["candidate.tau_i"] = max(values["delay"], SHORTEST_LAG)
    return parameters


ORDER = 30
BURN_IN = 0.005  # share at the start that is not used: the controller's state is unknown


class OutputError(Criterion):
    """Criterion: the measured position minus that of the simulated loop with the recorded command.

    Residuals can be whitened: encoder errors that have passed through the loop are predictable
    from one sample to the next.
    """

    name = "output error"
    every = 1

    def __init__(
        self,
        fmus: Path,
        recording: Recording,
        gains: Mapping[str, float],
        workers: int = 1,  # number of parallel runs
        law: Law | None = None,  # friction law of the drive FMU; LuGre by default
    ) -> None:
        self.space = ParameterSpace.of(law or friction_law())
        self.t = recording.t
        self.position = position_of(recording)
        self.loop = KnownLoop(fmus, recording, gains, workers=workers)
        self.held = [self.loop]
        # Whitening changes, but the positions that values give do not.
        self._simulated = Recent(self._simulate)
        self.step = recording.encoder_step
        self.noise = position_noise(self.position, self.step)
        self.whitening = np.ones(1)
        self._logs = [
            slice(one.begin + max(2 * ORDER, int(BURN_IN * (one.end - one.begin))), one.end)
            for one in recording.pieces
        ]
        self.used = together(self._logs)

    def raw(self, values: Values) -> Array:
        """Return measured minus simulated position (n,) [m]."""
        return np.asarray(self.position - self._simulated([tuple(values.items())])[0])

    def _simulate(self, points: Sequence[tuple[tuple[str, float], ...]]) -> list[Array]:
        runs = self.loop.results([Point(dict(values)) for values in points])
        return [run["candidate.x"] for run in runs]

    def residual(self, values: Values) -> Array:
        """Return the same, whitened (k,) [m]."""
        return self.white(self.raw(values))

    def run(self, points: Iterable[Values]) -> None:
        """Run the loops of several points side by side."""
        self._simulated([tuple(values.items()) for values in points])

    def white(self, raw: Array) -> Array:
        """Whiten a residual (n,) and leave out its start, (k,)."""
        white = lfilter(self.whitening, [1.0], raw)
        parts = [white[used] for used in self._logs]  # in each the position has its own constant
        return np.concatenate([part - part.mean() for part in parts])

    def whiten(self, values: Values) -> None:
        """Estimate the whitening filter from the residual of these values."""
        self.whitening = predictor_error(self.raw(values)[self.used], ORDER)

    def unexplained(self, values: Values, explained: Array) -> float:
        """Return the deviation of the residual over that of one (n,) [m] by the encoder alone."""
        expected = max(self.noise, float(np.std(explained[self.used])))
        return float(np.std(self.raw(values)[self.used])) / expected


def predictor_error(signal: Array, order: int) -> Array:
    """Return the filter (order + 1,) of a signal's one-step prediction error (Yule and Walker)."""
    n = len(signal)
    correlation = np.array([signal[k:] @ signal[: n - k] for k in range(order + 1)]) / n
    if correlation[0] <= 0.0:
        return np.ones(1)
    correlation[0] *= 1.0 + 1e-4
    return np.append(1.0, -solve_toeplitz(correlation[:-1], correlation[1:]))
