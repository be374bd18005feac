"""Runs of the motion from which the loop is learned, on the drive and on models of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stickslip import cosim, ga, models
from stickslip.evaluation.motions import REGION, Motion, Stroke, strokes
from stickslip.evaluation.validation import covered
from stickslip.models import Law
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import ControlError, Datasheet
from stickslip.servo.measurement import Array, blended_velocity
from stickslip.servo.observer import FORCE_NOISE
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.systems import Compensator, build_loop, nominal_parameters
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop

OBSERVER = "observer"  # name of the disturbance observer in the loop
CHAIN = (Compensator("compensator", "compensator"), Compensator(OBSERVER, "dob"))
"""The feedforward, and the observer of what it leaves."""
GENES = (
    ga.Gene("K_p", 0.2, 2.5, 1.0, unit="1"),
    ga.Gene("K_i", 0.1, 5.0, 1.0, unit="1"),
    ga.Gene("tau_f", 0.1, 4.0, 1.0, unit="1"),
    ga.Gene("m_ff", 0.01, 1.1, 0.5, unit="1"),
    ga.Gene("share", 0.05, 1.0, 1.0, unit="1"),
    ga.Gene("rate", 0.01, 50.0, 0.25, unit="1/s^0.5"),
    ga.Gene("observed", 0.01, 1.0, 0.1, unit="1"),
)
"""Lowest value, highest value and start of each; all are searched by their logarithm."""
PLAIN = {gene.name: gene.start for gene in GENES} | {"m_ff": 0.0, "share": 0.0, "observed": 0.0}
"""The reference: its gains alone, without any model of friction."""
FEEDFORWARD = PLAIN | {"share": 1.0}  # the reference with the feedforward of friction


@dataclass(frozen=True)
class TunedLoop:
    """A velocity loop with its compensators.

    ========  ====================================================================
    K_p, K_i  gains of the controller, in units of those of the reference
    tau_f     low-pass of its velocity estimate, in units of that of the reference
    m_ff      feedforward of inertia, in units of the identified mass
    share     of the feedforward of friction
    rate      of the disturbance that the observer follows [F_c / s^0.5]
    observed  share of the observer's estimate that is compensated
    ========  ====================================================================
    """

    loop: VelocityLoop  # with its gains and feedforward of inertia
    law: Law  # friction law of the feedforward
    friction: Mapping[str, float]  # its parameters at the whole force, by name, SI units
    share: float  # of that force
    observer: Observer  # of what the feedforward leaves

    def chain(self) -> list[Compensator]:
        """Return the compensators with their parameters; without an observer that has no share."""
        values = self.law.share(self.friction, self.share), self.observer.parameters()
        parts = [replace(one, values=own) for one, own in zip(CHAIN, values, strict=True)]
        return parts if self.observer.share else parts[:1]

    def parameters(self) -> dict[str, float]:
        """Return the parameters of the FMUs in a loop with ``CHAIN``, ``component.variable``."""
        parts = {
            "controller": {n: getattr(self.loop, n) for n in ("K_p", "K_i", "tau_f", "m_ff")},
            "nominal": nominal_parameters(self.loop),
            "compensator": self.law.share(self.friction, self.share),
            OBSERVER: self.observer.parameters(),
        }
        return {f"{part}.{n}": value for part, own in parts.items() for n, value in own.items()}

    def peak_sensitivity(self) -> float:
        """Return the peak sensitivity Ms; infinite if the loop is unstable."""
        return peak_sensitivity(self.loop, self.observer)


def tuned_loop(
    genes: Mapping[str, float],  # values by name
    reference: VelocityLoop,  # the loop in whose units the gains are
    law: Law,
    friction: Mapping[str, float],  # parameters of the law by name
    sheet: Datasheet,
) -> TunedLoop:
    """Return a candidate's loop; raise ControlError when it is unstable or has no observer."""
    axis, T_s, F_c = reference.axis, reference.T_s, friction["F_c"]
    gains = {name: genes[name] * getattr(reference, name) for name in ("tau_f", "K_p", "K_i")}
    loop = close_velocity_loop(axis, T_s, **gains, m_ff=genes["m_ff"] * axis.m)
    weights = FilterSpecification(sheet.encoder_step, FORCE_NOISE * F_c, genes["rate"] * F_c)
    try:
        estimator = design_velocity_filter(axis, T_s, weights)
    except np.linalg.LinAlgError as error:
        raise ControlError(f"no observer with a rate of {weights.disturbance_rate:g}") from error
    return TunedLoop(
        loop, law, friction, genes["share"], observer=Observer(estimator, genes["observed"])
    )


NOISY = {"noise": 1.0, "noise_x": 0.0, "noise_F": 0.0, "seed": 1.0}
"""Start values of models: noise is on, of no size yet, and drawn otherwise than the drive's."""

SMALL = Stroke(1.0, 0.025, 0.0, 0.1, counted=0.15)  # a small move, with the rest after it


def training_motion() -> Motion:
    """Return what a candidate runs: the motions of the validation, in short, and some between them.

    Errors of fast starts and reversals count where the paper evaluates them. The first start is
    that of a drive at rest without a history, the last one follows slow motion.
    """
    kinds = [
        ("fast", 0.022, (1, -1), Stroke(1.0, 0.4, 0.15, 0.0, counted=0.0)),
        *(
            ("small moves" if v < 5e-4 else "moves", v, (1, -1, 1, -1), SMALL)
            for v in (1.8e-4, 2.1e-4, 2.6e-4, 6e-4, 1.6e-3)
        ),
        *(
            ("slow reversals", v, (1, -1, 1), Stroke(1.0, 0.2, 0.0, 0.0, counted=0.2))
            for v in (4e-4, 1.6e-3)
        ),
        *(
            ("creep", v, (1, -1), Stroke(1.0, 5e-3, 1.5e-4 / v, 0.1, counted=1.5e-4 / v))
            for v in (1e-4, 2e-4, 3e-4, 6e-4, 1.5e-3)
        ),
        ("fast again", 0.03, (1, -1), Stroke(1.0, 0.45, 0.15, 0.0, counted=0.0)),
    ]
    moves = [
        (f"{kind}, {1e3 * v:g} mm/s", replace(stroke, speed=sign * v))
        for kind, v, signs, stroke in kinds
        for sign in signs
    ]
    motion = strokes("training", "What a candidate runs.", moves)
    regions = {
        name: tuple((t + REGION[0], t + REGION[1]) for t, _ in spans) if "fast" in name else spans
        for name, spans in motion.regions.items()
    }
    return replace(motion, regions=regions)


@dataclass(frozen=True)
class LoopBench:
    """A drive in loops that differ from a reference by their genes."""

    rig: FmuRig
    reference: VelocityLoop  # whose gains are tuned without a model, see ``tuned_pi``
    friction: Mapping[str, float]  # parameters of the compensator's law, as identified, by name

    def loop(self, genes: Mapping[str, float]) -> TunedLoop:
        """Return the loop of a candidate."""
        rig = self.rig
        return tuned_loop(genes, self.reference, rig.law, self.friction, sheet=rig.datasheet)


class LoopRuns:
    """Runs of the training motion with the drive, or with a model of it.

    It pickles, and each worker prepares the loop at its first run. Close it in the end. The law is
    that of the model, None for the drive; parameters of the model by these names differ between
    runs.
    """

    def __init__(self, bench: LoopBench, law: str | None = None, names: tuple[str, ...] = ()):
        self.bench, self._names, rig = bench, names, bench.rig
        self.motion = training_motion()
        t = rig.samples(self.motion.duration)
        self.v_cmd = self.motion.command.sample(t)
        self.drive = f"model_{law}" if law else "drive"
        if law:
            models.build_fmu("drive", rig.fmus, start=NOISY, law=law, called=self.drive)
        self._counted = {name: covered(t, spans) for name, spans in self.motion.regions.items()}
        loop = bench.reference.changed(m_ff=bench.reference.axis.m)
        shown = ("x_enc", "F_m", *(["v"] if law else []))
        specification = cosim.Specification(
            build_loop(rig.fmus, loop, CHAIN, drive=self.drive),
            step=rig.T_s,
            stop=(len(self.v_cmd) - 1) * rig.T_s,
            record=tuple(f"{self.drive}.{name}" for name in shown),
        )
        known = [*bench.loop(FEEDFORWARD).parameters(), *(f"{self.drive}.{n}" for n in names)]
        self._cost = ga.SimulatedCost(specification, known, _no_cost, loop.commands(self.v_cmd))

    def run(self, tuned: TunedLoop, values: Mapping[str, float] | None = None) -> cosim.Result:
        """Run a loop, with values of the model by name; raise CandidateFailed when an FMU fails."""
        numbers = [*tuned.parameters().values(), *((values or {})[name] for name in self._names)]
        return self._cost.result(np.array(numbers))

    def shown(self, run: cosim.Result) -> Array:
        """Return the velocity (n,) that encoder and motor force show [m/s]."""
        measured = run[f"{self.drive}.x_enc"], run[f"{self.drive}.F_m"]
        return blended_velocity(*measured, self.bench.reference.axis.m, self.bench.rig.T_s)

    def errors(self, v: Array) -> dict[str, float]:
        """Return RMS errors of a velocity (n,) relative to the command, by region."""
        return {
            name: float(np.sqrt(np.mean((v - self.v_cmd)[of] ** 2) / np.mean(self.v_cmd[of] ** 2)))
            for name, of in self._counted.items()
        }

    def close(self) -> None:
        """Free the FMUs."""
        self._cost.close()


def by_kind(errors: Mapping[str, float]) -> dict[str, float]:
    """Return the RMS of errors by region for each kind of motion."""
    squares: dict[str, list[float]] = {}
    for region, error in errors.items():
        squares.setdefault(region.split(",")[0], []).append(error**2)
    return {kind: float(np.sqrt(np.mean(of))) for kind, of in squares.items()}


def _no_cost(_: cosim.Result) -> float:
    """Stand for a cost where runs alone are wanted."""
    return 0.0
