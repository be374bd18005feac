"""What genetic learning may change of the velocity loop, and the loop that a candidate makes.

========  ====================================================================
K_p, K_i  gains of the controller, in units of those of the reference
tau_f     low-pass of its velocity estimate, in units of that of the reference
m_ff      feedforward of inertia, in units of the identified mass
share     of the feedforward of friction
rate      of the disturbance that the observer follows [F_c / s^0.5]
observed  share of the observer's estimate that is compensated
========  ====================================================================
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stickslip import ga
from stickslip.models import Law
from stickslip.servo.axis import ControlError
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.observer import FORCE_NOISE
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.systems import Compensator, nominal_parameters
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
    """A velocity loop with its compensators."""

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
    """Return the loop of a candidate.

    Raises ControlError when it is unstable, or no observer follows from the genes.
    """
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
