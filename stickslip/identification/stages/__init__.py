"""Section 2.4 of the paper: three experiments that find the parameters coarsely.

They see a drive through its commands and measurements only (``stickslip/rigs/contract.py``).
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from stickslip.catalog.parameters import (
    Estimate,
    estimated,
    friction_law,
    scaled_start,
    tabulated,
    unseen,
)
from stickslip.identification.stages.friction_map import FrictionMap, measure_friction
from stickslip.identification.stages.inertia import (
    Inertia,
    Presliding,
    measure_inertia,
    measure_presliding,
)
from stickslip.models import Law
from stickslip.rigs.contract import Rig
from stickslip.servo.axis import LoopSpecification
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop

__all__ = ["Estimate", "FrictionMap", "Identification", "Inertia", "Presliding", "identify"]


@dataclass(frozen=True)
class Identification:
    """What the three stages found, the velocity loop designed on it, and the compensator's law."""

    inertia: Inertia
    friction: FrictionMap
    presliding: Presliding
    loop: VelocityLoop
    law: Law = field(default_factory=friction_law)

    @property
    def estimates(self) -> dict[str, Estimate]:
        """m, b and the parameters of the law by name, in SI units."""
        friction, law = self.friction, self.law
        found = {"F_s": friction.F_s, "F_c": friction.F_c, "v_s": friction.v_s}
        found |= self.presliding.estimates
        deflection = friction.F_c.value / self.presliding.stiffness
        return {"m": self.inertia.m, "b": friction.b} | {
            name: found.get(name)
            or unseen(scaled_start(law.parameters[name], friction.F_c.value, deflection))
            for name in estimated(law)
        }

    @property
    def tuned(self) -> dict[str, Estimate]:
        """The parameters of the compensator by name: those of its friction law."""
        return {name: self.estimates[name] for name in estimated(self.law)}

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the drive did not show, a line each."""
        shown = self.friction.warning if "v_s" in self.law.parameters else ""
        return tuple(filter(None, (shown, self.presliding.warning)))


def identify(
    rig: Rig, specification: LoopSpecification, on_stage: Callable[[str], object] = lambda _: None
) -> Identification:
    """Run the three stages; the velocity loop that stage 2 needs is designed on stage 1."""
    on_stage("inertia")
    inertia = measure_inertia(rig)
    axis = rig.datasheet.axis(inertia.m.value, max(inertia.b.value, 0.0))
    on_stage("friction over velocity, break-away")
    friction = measure_friction(rig, design_velocity_loop(axis, specification), inertia.F_c.value)
    inertia.check(float(friction.curve(np.array([inertia.speed]))[0]))
    known = {
        "m": inertia.m.value,
        "b": max(friction.b.value, 0.0),
        "F_s": friction.place * friction.F_s.value,
        "F_c": friction.place * friction.F_c.value,
        "v_s": friction.v_s.value,
    }
    on_stage("presliding")
    mean = 0.5 * sum(friction.breakaway)
    weaker = min(friction.breakaway) / mean
    force = weaker * min(mean, 1.2 * known["F_c"])
    known = {n: one for n, one in known.items() if n in tabulated(rig.law)}
    presliding = measure_presliding(rig, known, force)
    loop = design_velocity_loop(rig.datasheet.axis(known["m"], known["b"]), specification)
    return Identification(inertia, friction, presliding, loop, law=rig.law)
