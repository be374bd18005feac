"""The inverse model: the force that the recorded motion implies against the measured one.

    F(t - delay) = m a + b v + s F_f(v) + F_0

F_f comes from the compensator FMU, driven by the recorded velocity, whose sudden changes are kept;
s is 1, or by what a weight that the drive holds multiplies friction.
All terms are low-passed alike, in quick motion less: else moves of few samples would vanish.
They are compared in rows, means of q samples: friction changes slower than a fast log is sampled,
and encoder noise that outweighs the acceleration would hide the mass.
Where friction itself was measured, it stands alone: F = F_f(v) + F_0.
A law without presliding gives any force up to that of break-away at rest: there F_f balances F.
"""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from stickslip import cosim, ga
from stickslip.catalog.parameters import DRIVE, ParameterSpace, Values, friction_law, presliding
from stickslip.identification.criteria.motion import (
    SHARE,
    SmoothMotion,
    means,
    measured_force,
    position_noise,
    position_of,
    samples_per_row,
    smooth_motion,
    velocity_noise,
)
from stickslip.identification.criteria.runs import Criterion, Recent, Rows, Runs, together
from stickslip.logs import Recording
from stickslip.logs.excitation import reverses_quickly
from stickslip.models import Law
from stickslip.servo.lanes import Run
from stickslip.servo.measurement import Array, derivative, smoothed
from stickslip.thresholds import row_rate

FEWEST = 4_000  # rows that further averaging leaves
EDGE = 4.0  # periods of the cut-off that the filter needs at either end
GUARD = 1.0, 0.25
"""Time around rest in which the low-pass mixes both, in periods of its cut-off: as a rule, and
where the drive reverses quickly."""
EVERY = int(1.0 / (4.0 * SHARE))  # the low-pass leaves less than a quarter of the band
REST = 3.0  # speed up to which a drive may be at rest, in deviations of its noise
QUICKER = (2.0, 4.0, 8.0)  # cut-offs of sudden changes of the velocity, over that of the force
QUICKEST = 0.4  # the same over the rows' rate, at most


def friction_run(fmus: Path, v: Array, T_s: float) -> cosim.Specification:
    """Return the run of a compensator along velocities (n,) [m/s]; it gives ``F_f``."""
    system = cosim.System("friction")
    system.add("compensator", fmus / "compensator.fmu", {"hold": False})
    system.expose("v", "compensator.v")
    return cosim.Specification(
        system, step=T_s, stop=(len(v) - 1) * T_s, record=("compensator.F_f",)
    )


def row_length(recording: Recording) -> int:
    """Return how many samples a row takes; measured friction needs no acceleration."""
    position, T_s = position_of(recording), recording.T_s
    least = max(1, round(1.0 / (row_rate.FASTEST * T_s)))
    if recording.force is None:
        return least
    noise = position_noise(position, recording.encoder_step)
    return samples_per_row(position, T_s, noise, least=least, share=row_rate.NOISE, rows=FEWEST)


class InverseModel(Criterion):
    """Criterion: the measured force minus the force that the values predict.

    Attributes
    ----------
    fmus, recording, cutoff, law, q : as given
    t, T_s, position, force, motion : of the n rows
    used, logs : which of the rows count, and which are those of each log
    moves : (n,) where the drive is not at rest, nor near it within the memory of the low-pass
    slides : (n,) where friction follows from the motion; everywhere for a law with presliding
    """

    name = "inverse model"

    def __init__(
        self,
        fmus: Path,  # folder of the FMUs
        recording: Recording,  # with position, and force or friction
        cutoff: float | None = None,  # of the low-pass [Hz]; by default a share of the rows' rate
        workers: int = 1,  # number of parallel runs
        law: Law | None = None,  # friction law of the compensator FMU; LuGre by default
        q: int | None = None,  # samples in a row; by default as the recording requires
    ) -> None:
        self.fmus, self.recording = fmus, recording
        self.space = ParameterSpace.of(law or friction_law())
        position, T_s = position_of(recording), recording.T_s
        noise = position_noise(position, recording.encoder_step)
        self.measures_friction = recording.force is None
        self.q = q or row_length(recording)
        self.T_s = self.q * T_s
        is_quick = reverses_quickly(recording)
        self.cutoff = cutoff or (row_rate.QUICK if is_quick else 1.0) * SHARE / self.T_s
        self.every = 1 if is_quick else EVERY
        self.t, self.position = means(recording.t, self.q), means(position, self.q)
        self.force = smoothed(means(measured_force(recording), self.q), self.T_s, self.cutoff)
        self.motion: SmoothMotion = smooth_motion(self.position, self.T_s, self.cutoff)
        factor = recording.friction_factor
        self.factor = np.ones_like(self.t) if factor is None else means(factor, self.q)
        self.used = self._used()
        self.law = law or friction_law()
        rests = np.abs(self.motion.v) <= REST * velocity_noise(noise, T_s, self.cutoff)
        near = np.ones(2 * int(GUARD[is_quick] / self.cutoff / self.T_s) + 1)
        self.moves = np.convolve(rests, near, "same") < 0.5
        self.slides = self.moves | bool(presliding(self.law))
        # The velocity of row n + 1 is the one at the end of the step from t[n].
        v = self._sudden(noise / np.sqrt(self.q))
        self.inputs = {"v": np.append(v[1:], v[-1])}
        self.linear = np.column_stack([self.motion.a, self.motion.v, np.ones_like(self.t)])
        self._runs = [
            Runs(friction_run(fmus, self.motion.v[log], self.T_s), workers) for log in self.logs
        ]
        self.runs, self.held = self._runs[0], self._runs
        between = np.ones_like(self.moves)
        for log in self.logs:
            between[log] = False
        self.slides &= ~between
        self._of_laws = Recent(self._frictions_of_laws)

    def _sudden(self, noise: float) -> Array:
        """Return the velocity (n,) with which the law runs [m/s], of a position with noise [m].

        Where it changes by more than its noise, it is low-passed less: a low-pass makes a drive
        that stops swing back by more than a stiff contact bends, and so its friction reverse.
        """
        v = self.motion.v
        for times in QUICKER:
            cutoff = min(times * self.cutoff, QUICKEST / self.T_s)
            quick = derivative(smoothed(self.position, self.T_s, cutoff), self.T_s)
            sure = REST * velocity_noise(noise, self.T_s, cutoff)
            v = np.where(np.abs(quick - v) > sure, quick, v)
        return v

    def _used(self) -> Rows:
        """Return the rows that count: not those in which a log begins or ends."""
        self.logs, rows = [], []
        for one in self.recording.pieces:
            begin, end = -(-one.begin // self.q), min(one.end // self.q, len(self.t))
            edge = min(int(EDGE / self.cutoff / self.T_s) + 1, (end - begin) // 10)
            rows.append(slice(begin + edge, end - edge))
            self.logs.append(slice(begin, end))
            if one.load:
                self.force[begin:end] -= one.load * self.motion.a[begin:end]
        return together(rows)

    @property
    def samples_used(self) -> Rows:
        """Which samples of the recording the rows that count are made of."""
        if isinstance(self.used, slice):
            return slice(self.used.start * self.q, self.used.stop * self.q)
        return (self.used[:, np.newaxis] * self.q + np.arange(self.q)).ravel()

    def friction(self, values: Values) -> Array:
        """Return F_f (n,) [N] along the recorded motion."""
        return self._of_laws([_law_of(values)])[0]

    def _frictions_of_laws(self, laws: Sequence[tuple[tuple[str, float], ...]]) -> list[Array]:
        every = [{f"compensator.{name}": value for name, value in law} for law in laws]
        found = np.zeros((len(laws), len(self.t)))
        for log, runs in zip(self.logs, self._runs, strict=True):  # each begins at rest
            inputs = {name: signal[log] for name, signal in self.inputs.items()}
            results = runs.results([Run(one, inputs) for one in every])
            found[:, log] = [run["compensator.F_f"] * self.factor[log] for run in results]
        return list(found)

    def predicted(self, values: Values) -> Array:
        """Return the force (n,) [N] that the values predict for the motion, low-passed."""
        rigid, friction = self._rigid(values), self.friction(values)
        if not self.slides.all():
            most = values["F_s" if self.law.steady == "stribeck" else "F_c"] * self.factor
            held = np.clip(self.measured(values) - rigid, -most, most)
            friction = np.where(self.slides, friction, held)
        return np.asarray(rigid + smoothed(friction, self.T_s, self.cutoff))

    def _rigid(self, values: Values) -> Array:
        weights = np.array([values["m"], values["b"], values["F_0"]])
        if self.measures_friction:
            weights[:2] = 0.0
        return np.asarray(self.linear @ weights)

    def beside_rigid(self, values: Values) -> Array:
        """Return the measured force (n,) [N] that mass, viscous friction and offset leave."""
        return self.measured(values) - self._rigid(values)

    def measured(self, values: Values) -> Array:
        """Return the measured force (n,) [N] without its delay, low-passed."""
        return np.interp(self.t - values["delay"], self.t, self.force)

    def residual(self, values: Values) -> Array:
        """Return measured minus predicted force (k,) [N]."""
        return (self.measured(values) - self.predicted(values))[self.used]

    def at_samples(self, signal: Array) -> Array:
        """Return a signal of the rows (n,) at each sample of the recording."""
        if self.q == 1:
            return signal
        at = np.clip(self.recording.t, self.t[0], self.t[-1])
        return np.asarray(CubicSpline(self.t, signal)(at))

    def run(self, points: Iterable[Values]) -> None:
        """Run the friction of several points side by side."""
        self._of_laws([_law_of(values) for values in points])


def _law_of(values: Values) -> tuple[tuple[str, float], ...]:
    return tuple(item for item in values.items() if item[0] not in DRIVE)


class ForceCost:
    """Sum of squares [N^2] that the best m, b and F_0 leave of a candidate's friction.

    A candidate is a row of parameters of the law; see ``ga.Evaluate``.
    """

    fatal = (cosim.CosimError,)

    def __init__(
        self,
        model: InverseModel,
        names: Sequence[str],  # of the k parameters in a row
        delay: float,  # of the force [s]
    ) -> None:
        self._model, self._names = model, names
        force = np.interp(model.t - delay, model.t, model.force)
        self._target = np.where(model.slides, force, 0.0)
        columns = model.linear[:, 2:] if model.measures_friction else model.linear
        self._basis = np.linalg.qr(columns * model.slides[:, np.newaxis])[0]  # (n, j)

    def __call__(self, values: Array) -> float:
        """Return the cost of a candidate (k,)."""
        return self.together(values[np.newaxis])[0]()

    def together(self, rows: Array) -> list[Callable[[], float]]:
        """Run candidates (n, k) side by side; return what gives the cost of each."""
        points = [dict(zip(self._names, row, strict=True)) for row in rows.tolist()]
        with suppress(cosim.SimulationError):  # the candidate itself tells it
            self._model.run(points)
        return [partial(self._cost, point) for point in points]

    def _cost(self, point: Values) -> float:
        try:
            friction = self._model.friction(point)
        except cosim.SimulationError as error:
            raise ga.CandidateFailed(str(error)) from error
        friction = smoothed(friction, self._model.T_s, self._model.cutoff)
        rest = self._target - np.where(self._model.slides, friction, 0.0)
        # No linear algebra: its sums depend on its threads, in which workers differ.
        for direction in self._basis.T:
            rest = rest - direction * np.sum(direction * rest)
        return float(np.sum(rest * rest))
