"""What a trial of compensators needs of a drive, and what it gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import pandas as pd

from stickslip.cosim import Trapezoid
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.trial.candidates import CompensatorComparison
from stickslip.trial.guards import Benefit, Drive, Hold
from stickslip.trial.observed import ObserverTrial


class Loops(NamedTuple):
    """Velocity loops of a drive."""

    plain: VelocityLoop  # without compensation
    compensated: VelocityLoop  # in which the compensator runs
    # whether the drive runs in them; False where they only serve to try the compensator
    known: bool = True


@dataclass(frozen=True)
class SimulatedTrial:
    """What trying a compensator on simulated drives gave.

    Attributes
    ----------
    command, datasheet, drives : what it was tried on
    benefit : tracking errors with feedforward of the law, and the share of its force that passes
    warnings : of the guards, a line each
    others : the same as ``benefit`` for other ways to compensate
    observed : what an observer adds; None where none was tried
    holds : how a cascade holds its position, by name of the way to compensate; else empty
    compared : all compensators that were tried; None where there is only the default
    """

    command: Trapezoid
    datasheet: Datasheet
    benefit: Benefit
    warnings: tuple[str, ...]
    drives: tuple[Drive, ...] = ()
    others: tuple[Benefit, ...] = ()
    observed: ObserverTrial | None = None
    holds: Mapping[str, Hold] = field(default_factory=dict)
    compared: CompensatorComparison | None = None

    def table(self) -> pd.DataFrame:
        """Return a row for each way to compensate, drive and command.

        Speeds and errors are in m/s, of the figure ``position`` in m; rad for a rotary drive.
        """
        rows = [
            {
                "compensation": benefit.variant.name,
                "share": benefit.share,
                "drive": row.drive,
                "command": row.command,
                "figure": row.figure,
                "speed": row.speed,
                "without": row.without,
                "with": row.compensated,
                "ratio": row.ratio,
            }
            for benefit in (self.benefit, *self.others)
            for row in benefit.rows
        ]
        return pd.DataFrame(rows)
