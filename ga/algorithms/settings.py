"""How to learn, two presets of it, and when to stop."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal, get_args, get_type_hints

from stickslip.ga.errors import SettingsError

_RATES = ("elite_rate", "mutation_rate", "crossover_rate", "k1", "k2", "near_share")
_RANGES: dict[str, tuple[float, float]] = {
    **dict.fromkeys(_RATES, (0, 1)),
    "population": (4, math.inf),
    "generations": (1, math.inf),
    "near_spread": (1e-12, math.inf),
    "resolution": (1e-12, 0.5),
    "threshold": (0, math.inf),
    "patience": (1, math.inf),
    "restarts": (0, math.inf),
}


@dataclass(frozen=True)
class Settings:
    """Numbers and operators of the genetic algorithm; the defaults are the preset ``default``.

    Parameters
    ----------
    population : candidates in a generation, at least 4
    generations : how many generations to evaluate, the first included
    elite_rate : share of the population that passes on unchanged (and is not evaluated again);
        at least one candidate does
    mutation_rate : probability that a gene of a child mutates
    crossover : ``differential`` or ``arithmetic``, see ``ga/operators/breeding.py``
    crossover_rate : ``differential`` only: probability that a gene comes from the crossover
    k1, k2 : ``arithmetic`` only: constants of the adaptive crossover probability (7)
    mutation : ``spread`` or ``uniform``, see ``ga/operators/breeding.py``
    survival : ``rival``: a child takes its parent's place if it costs no more;
        ``generational``: it always does
    encoding : ``log`` or ``linear``, see ``ga/problem/problem.py``
    resolution : step of a gene's string on [0, 1]; None leaves it continuous. A repaired gene may
        lie between two steps.
    near_share : share of the first generation drawn around the start; the rest is drawn uniformly
    near_spread : standard deviation of that part, on the string's scale of [0, 1]
    ahead : a generation is bred before the costs of the one before are known, so that no worker
        waits for the slowest
    threshold : stop as soon as the best cost is at most this, in the cost's unit; None never does
    adaptive : the mutation rate follows what succeeds, see ``ga/operators/breeding.py``
    surrogates : some children are where models of the cost are lowest, see
        ``ga/operators/surrogates.py``
    patience : generations in which the best cost has not fallen by 1 % after which the search
        restarts, where a bowl through all candidates is lowest or anywhere; None never does
    restarts : how often at most. A search that then comes to rest again is at its end.

    Raises
    ------
    SettingsError : a number out of its range or an unknown name
    """

    population: int = 10
    generations: int = 100
    elite_rate: float = 0.2
    mutation_rate: float = 0.1
    crossover: Literal["differential", "arithmetic"] = "differential"
    crossover_rate: float = 0.9
    k1: float = 1.0
    k2: float = 1.0
    mutation: Literal["spread", "uniform"] = "spread"
    survival: Literal["rival", "generational"] = "rival"
    encoding: Literal["log", "linear"] = "log"
    resolution: float | None = None
    near_share: float = 0.8
    near_spread: float = 0.05
    ahead: bool = True
    threshold: float | None = None
    adaptive: bool = True
    surrogates: bool = True
    patience: int | None = 50
    restarts: int = 10

    def __post_init__(self) -> None:
        for field, (low, high) in _RANGES.items():
            value = getattr(self, field)
            if value is not None and not low <= value <= high:
                raise SettingsError(f"{field} must be from {low:g} to {high:g}, got {value!r}")
        if self.elites >= self.population:
            raise SettingsError(f"elite_rate must be below 1, got {self.elite_rate!r}")
        hints = get_type_hints(Settings)
        for field in ("crossover", "mutation", "survival", "encoding"):
            names, name = get_args(hints[field]), getattr(self, field)
            if name not in names:
                raise SettingsError(f"{field} must be one of {', '.join(names)}, got {name!r}")

    @property
    def elites(self) -> int:
        """How many candidates pass on unchanged."""
        return max(1, round(self.elite_rate * self.population))


DEFAULT = Settings()

PAPER = Settings(
    population=10,
    generations=100,
    elite_rate=0.2,
    mutation_rate=0.15,
    crossover="arithmetic",
    k1=1.0,
    k2=1.0,
    mutation="uniform",
    survival="generational",
    encoding="linear",
    resolution=1e-4,
    near_share=0.0,
    ahead=False,
    adaptive=False,
    surrogates=False,
    patience=None,
    restarts=0,
)
"""Table 3 and Steps 1 to 4 of the paper. Where it is silent, this is how we read it:

- k1 and k2 of (7) are not given: 1.0, the choice of Srinivas and Patnaik (1994), who proposed (7).
- "Number of gene 10" is not explained; it cannot be the number of parameters, which is five. It
  probably counts the digits of the real-number string, and has no counterpart here: a string is
  one real number per parameter, in steps of the stated resolution.
- "Initial generation based on experience": the identified values are one individual, the others
  are uniform over the search range, which is itself set around the identified values.
- "Elitist selection": the elite passes on unchanged; parents are drawn from the whole generation
  in proportion to fitness, because (7) speaks of parents below the mean.
- Crossover of real numbers: weighted means of both parents. Mutation: a new value of the range.
- The elite is not evaluated again, because its cost is known: 802 runs instead of 1,000.
"""

PRESETS = {"paper": PAPER, "default": DEFAULT}
PROGRESS = 0.01  # a best cost must fall by this fraction to count as progress


@dataclass(frozen=True)
class Limits:
    """What ends a run, whichever comes first; None never does.

    Parameters
    ----------
    generations : so many batches were evaluated
    evaluations : another batch would exceed this number of candidates
    target : the best cost is at most this, in the cost's unit
    patience : the best cost has not fallen by 1 % for so many evaluations

    Raises
    ------
    SettingsError : a limit that is not positive; a negative target
    """

    generations: int | None = None
    evaluations: int | None = None
    target: float | None = None
    patience: int | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not (value >= 0 if field.name == "target" else value > 0):
                raise SettingsError(f"{field.name} must be above 0, or None, got {value!r}")

    def reached(
        self, *, generations: int, evaluations: int, batch: int, best: float, stagnant: int
    ) -> str | None:
        """Return which limit ends a run that has come so far, as a sentence, or None."""
        if self.target is not None and best <= self.target:
            return f"the best cost {best:.6g} reached the threshold {self.target:.6g}"
        if spent := self.spent(generations=generations, evaluations=evaluations, batch=batch):
            return spent
        if self.patience is not None and stagnant >= self.patience:
            return f"stagnation: the best cost has not fallen by 1 % in {stagnant} evaluations"
        return None

    def spent(self, *, generations: int, evaluations: int, batch: int) -> str | None:
        """Return which of the limits that are known beforehand ends the run, or None."""
        if self.generations is not None and generations >= self.generations:
            return f"all {self.generations} generations are done"
        if self.evaluations is not None and evaluations + batch > self.evaluations:
            return (
                f"the budget of {self.evaluations} evaluations is used "
                f"({evaluations} done, another generation takes {batch})"
            )
        return None
