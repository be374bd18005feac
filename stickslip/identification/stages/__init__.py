"""Section 2.4 of the paper: three experiments that find the parameters coarsely.

They see a drive through its commands and measurements only (``stickslip/servo/rig.py``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stickslip.identification.stages.estimate import Estimate
from stickslip.identification.stages.friction_map import FrictionMap, measure_friction
from stickslip.identification.stages.inertia import Inertia, measure_inertia
from stickslip.identification.stages.presliding import Presliding, measure_presliding
from stickslip.servo.rig import Rig
from stickslip.servo.velocity_loop import LoopSpecification, VelocityLoop, design_velocity_loop

__all__ = ["Estimate", "FrictionMap", "Identification", "Inertia", "Presliding", "identify"]


@dataclass(frozen=True)
class Identification:
    """What the three stages found, and the velocity loop designed on it."""

    inertia: Inertia
    friction: FrictionMap
    presliding: Presliding
    loop: VelocityLoop

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The parameters of Table 2 by name, in SI units."""
        return {
            "m": self.inertia.m,
            "b": self.friction.b,
            "F_s": self.friction.F_s,
            "F_c": self.friction.F_c,
            "v_s": self.friction.v_s,
            "sigma_0": self.presliding.sigma_0,
            "sigma_1": self.presliding.sigma_1,
        }


def identify(
    rig: Rig, specification: LoopSpecification, on_stage: Callable[[str], object] = lambda _: None
) -> Identification:
    """Run the three stages; the velocity loop that stage 2 needs is designed on stage 1.

    Raises
    ------
    IdentificationError
        When a recording does not show what its stage looks for.
    stickslip.servo.axis.ControlError
        When the axis found cannot meet the specification.
    """
    on_stage("inertia")
    inertia = measure_inertia(rig)
    axis = rig.datasheet.axis(inertia.m.value, max(inertia.b.value, 0.0))
    on_stage("friction over velocity, break-away")
    friction = measure_friction(rig, design_velocity_loop(axis, specification), inertia.F_c.value)
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
    presliding = measure_presliding(rig, known, weaker * min(mean, 1.2 * known["F_c"]))
    loop = design_velocity_loop(rig.datasheet.axis(known["m"], known["b"]), specification)
    return Identification(inertia, friction, presliding, loop)
