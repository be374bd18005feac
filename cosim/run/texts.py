"""Variables of type String over a run: what they hold, where it changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from stickslip.cosim.errors import SimulationError
from stickslip.cosim.fmu.batch import Batch

Changes = Mapping[str, Sequence[tuple[float, str]]]
"""Name -> times (s) and what the variable holds from each on."""

_MOST = 10_000_000  # characters of a run


class Texts:
    """Reads strings at points in time and keeps those that differ from the ones before.

    Parameters
    ----------
    batches : names of the variables, room for them and the function that reads it
    """

    def __init__(
        self, batches: Sequence[tuple[Sequence[str], Batch, Callable[[Batch], None]]]
    ) -> None:
        self._batches = batches
        self._size = 0
        self.changes: dict[str, list[tuple[float, str]]] = {
            name: [] for names, _, _ in batches for name in names
        }

    def note(self, time: float) -> None:
        """Read all strings at a point in time (s).

        Raises
        ------
        SimulationError
            When an FMU refuses, or the strings of the run are too long to be kept.
        """
        for names, batch, read in self._batches:
            read(batch)
            for name, value in zip(names, batch.values, strict=True):
                text = (value or b"").decode(errors="replace")
                changes = self.changes[name]
                if changes and changes[-1][1] == text:
                    continue
                changes.append((float(time), text))
                self._size += len(text)
                if self._size > _MOST:
                    raise SimulationError(
                        f"{name}: the strings recorded up to t = {time:.9g} s have more than"
                        f" {_MOST:,} characters; record without them (--record)"
                    )
