"""What other gains of the controller promise: a few loops, tried before anybody tunes.

Each runs on the drive as fitted. Those that do best there are then run on the drives of a search,
within its limits; the first that is in no motion worse than the present loop is reported.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import product
from statistics import geometric_mean

from stickslip.loops.drive_loop import DriveLoop
from stickslip.loops.family_cost import FamilyCost, ratios
from stickslip.servo.axis import ControlError
from stickslip.storage.codec import entry
from stickslip.thresholds import kept, offer
from stickslip.tuning.search import Ratios

FACTORS = {"K_p": (0.4, 0.6, 1.0, 1.6, 2.5), "K_i": (0.5, 1.0, 2.0, 4.0)}
CASCADE = {"K_p": (1.0, 1.6, 2.5), "K_i": (0.5, 1.0, 2.0, 4.0), "K_x": (1.0, 1.6)}
"""Gains that are tried, over the present ones."""
FINALISTS = 4  # loops that are run on more drives, at most


@dataclass(frozen=True)
class OtherGains:
    """The best of the loops that were tried."""

    tried: int
    drives: int  # on which the error is, those of a search
    peak_sensitivity: tuple[float, float]  # Ms of the present loop, and of the best one
    # its gains over the present ones; empty where none is better
    factors: Mapping[str, float] = field(default_factory=dict, metadata=entry("1"))
    # what it leaves of the error, RMS over the drives: geometric mean over the motions, and largest
    error: float = field(default=1.0, metadata=entry("1"))
    worst: float = field(default=1.0, metadata=entry("1"))

    @property
    def sentence(self) -> str:
        """What tuning would bring, in a sentence without its end."""
        if self.error > offer.OTHER_GAINS:
            best = f"the best of {self.tried} loops tried leaves {self.error:.2f} of the error"
            if not self.factors:
                best = f"none of {self.tried} loops tried is better and in no motion worse"
            return f"other gains: {best}; 'stickslip tune' searches further"
        *first, last = (f"{factor:g} times {name}" for name, factor in self.factors.items())
        gains = f"{', '.join(first)} and {last}" if first else last
        before, after = self.peak_sensitivity
        return (
            f"with {gains} the tracking error on {self.drives} simulated drives is {self.error:.2f}"
            f" of that in the present loop, and {self.worst:.2f} in the worst motion, at a peak"
            f" sensitivity of {after:.3g} instead of {before:.3g}"
        )


def try_other_gains(cost: FamilyCost) -> OtherGains:
    """Try the gains of a grid in place of the present ones."""
    before = cost.sensitivity(cost.start)
    loops = [(factors, one, cost.sensitivity(one)) for factors, one in _loops(cost.start)]
    number = len(loops), len({drive.name for drive, _ in cost.few})
    tried = []
    for factors, one, Ms in loops:
        if Ms <= kept.SENSITIVITY:
            found = ratios(cost.rows(one, cost.first))
            tried.append((max(found.values()) > kept.LOOP_WORSE, _mean(found), factors, one, Ms))
    for *_, factors, one, Ms in sorted(tried, key=lambda each: each[:2])[:FINALISTS]:
        if cost.excess(one) <= 1.0:
            found = ratios(cost.rows(one, cost.few))
            error, worst = _mean(found), max(found.values())
            if error < 1.0 and worst <= kept.LOOP_WORSE:
                return OtherGains(*number, (before, Ms), factors, error=error, worst=worst)
    return OtherGains(*number, (before, before))


def _loops(start: DriveLoop) -> Iterator[tuple[dict[str, float], DriveLoop]]:
    """Yield the loops of the grid that are stable, and their gains over the present ones."""
    grid = CASCADE if start.loop.K_x else FACTORS
    grid = {name: factors for name, factors in grid.items() if getattr(start.loop, name)}
    for each in product(*grid.values()):
        factors = {name: k for name, k in zip(grid, each, strict=True) if k != 1.0}
        gains = {f"controller.{name}": k * getattr(start.loop, name) for name, k in factors.items()}
        with suppress(ControlError):
            if factors:
                yield factors, start.with_values(gains)


def _mean(found: Ratios) -> float:
    """Return the geometric mean of the ratios of RMS errors."""
    return geometric_mean(ratio for key, ratio in found.items() if "RMS" in key)
