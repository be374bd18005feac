"""What an experiment will not show of a drive in its loop, said before it is run."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from stickslip.errors import UsageError
from stickslip.planning.experiment import Stretch
from stickslip.planning.parts import Limits, levels, slowest_creep
from stickslip.thresholds import experiment


@dataclass(frozen=True)
class DataSheet:
    """What is known of a drive before it is recorded; for a rotary drive read rad for m.

    Raises UsageError when a value is not positive.
    """

    friction: float | None = None  # Coulomb friction, about [N]: of a data sheet or a first move
    encoder: float | None = None  # step [m]
    K_p: float | None = None  # gains of the velocity loop [N s/m], [N/m]
    K_i: float | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is not None and not 0.0 < value < math.inf:
                raise UsageError(f"{name} = {value}: expected more than 0")


def not_shown(
    sheet: DataSheet,
    limits: Limits,
    stretches: Iterable[Stretch],
    length: tuple[str, float] = ("m", 1.0),
) -> Iterator[str]:
    """Yield a sentence for each limit of what will show; ``length`` is a unit and its value [m]."""
    samples = sum(one.end - one.begin for one in stretches if "v_s" in one.part.shows)
    lasts = samples / limits.rate
    creep = 0.25 * lasts / levels(lasts)  # time for which each speed is held [s]
    unit, size = length
    slowest = {"the plan creeps no slower": slowest_creep(limits)}
    if sheet.friction and sheet.K_i:
        rise = experiment.RISE * sheet.friction
        slowest["breaks away too late below that, a higher K_i helps"] = rise / (sheet.K_i * creep)
    if sheet.friction and sheet.K_p:
        slowest["sticks and slips below that, a higher K_p helps"] = (
            experiment.STICKS * sheet.friction / sheet.K_p
        )
    if sheet.encoder:
        slowest["the encoder gives too few steps below that"] = (
            experiment.STEPS * sheet.encoder / creep
        )
    why, least = max(slowest.items(), key=lambda one: one[1])
    yield (f"F_s and v_s: not shown of a drive with v_s below {least / size:.2g} {unit}/s ({why})")
    if sheet.encoder:
        bend = experiment.STEPS * sheet.encoder
        yield (
            f"sigma_0 and sigma_1: not shown of a drive that breaks away within {bend / size:.2g} "
            f"{unit}, {experiment.STEPS:g} steps of the encoder"
        )
