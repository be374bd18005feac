"""What a drive showed of the loops that it ran while it was tuned."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.models.export.units import motion_unit
from stickslip.presentation.table import Column, Table
from stickslip.trial.benefit import FIGURES
from stickslip.trial.hold import Hold


@dataclass(frozen=True)
class RigMotion:
    """One motion of the drive in one loop."""

    loop: str  # display name
    motion: str  # display name
    errors: tuple[float, ...]  # RMS of velocity [m/s] and, in a cascade, position [m], as measured
    force: float  # largest of the motor [N]
    ripple: float  # RMS of the motor force above the crossover frequency of the present loop [N]
    hold: Hold  # how the position swings in the rest after the motion
    # of the errors to those of the present loop, each with what the steps of the encoder show
    ratios: tuple[float, ...] = ()


@dataclass(frozen=True)
class RigTrial:
    """What the drive showed of the loops that it ran."""

    rig: str  # display name
    motions: tuple[RigMotion, ...]
    budget: int  # of motions
    stopped: str  # why it ended early; empty when all loops ran
    rotary: bool = False

    @property
    def table(self) -> Table:
        """The errors of each motion."""
        columns = (
            Column("loop", "", "loop", "Loop"),
            Column("motion", "", "motion", "Motion"),
            Column("figure", "", "error of", "Error of"),
            Column("unit", "", "unit", "Unit"),
            Column("error", ".4g", "RMS", "RMS"),
            Column("ratio", ".3f", "of the present", "Of the present"),
        )
        rows = [
            {"loop": one.loop, "motion": one.motion, "figure": figure}
            | {"unit": motion_unit(unit, rotary=self.rotary), "error": error, "ratio": ratio}
            for one in self.motions
            for figure, unit, error, ratio in zip(
                FIGURES, ("m/s", "m"), one.errors, one.ratios, strict=False
            )
        ]
        return Table(columns, rows)

    @property
    def sentence(self) -> str:
        """What the drive showed, in a sentence without its end."""
        used = f"{self.rig} ran {len(self.motions)} of at most {self.budget} motions"
        if self.stopped:
            return f"{used}; {self.stopped}; the present gains are set again"
        return used
