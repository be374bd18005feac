"""What a run recorded."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.system import System
from stickslip.fmi.files import atomic_write
from stickslip.fmi.messages import suggestion

if TYPE_CHECKING:
    import pandas as pd


class Result:
    """Signals over time; ``result["drive.v"]`` is an array (n,) float64.

    Attributes
    ----------
    time : (n,) float64, s; n is n_steps + 1 unless the record says otherwise
    stopped : who asked to end the run before its time and when; None where the run is whole
    names : of the signals
    values : (n, len(names)) float64, each in its unit
    sum_of_squares : label -> sum that the record asked for, in the unit of its signal squared
    """

    def __init__(
        self,
        time: Array,
        values: Array,
        names: Sequence[str],
        system: System,
        stopped: str | None = None,
        sum_of_squares: dict[str, float] | None = None,
    ) -> None:
        self.stopped = stopped
        self.time = time
        self.values = values
        self.names = tuple(names)
        self.sum_of_squares = sum_of_squares or {}
        self._system = system

    def __getitem__(self, name: str) -> Array:
        try:
            return self.values[:, self._columns[name]]
        except KeyError:
            if (array := self._array(name)) is not None:
                return array
            raise KeyError(f"{name!r} was not recorded{suggestion(name, self.names)}") from None

    def _array(self, name: str) -> Array | None:
        """Return an array of which all elements were recorded, (n, *dimensions)."""
        if not any(known.startswith(f"{name}[") for known in self.names):
            return None
        variable = self._system.variable(name)
        prefix = name.removesuffix(variable.name)
        elements = [prefix + element.name for element in variable.elements()]
        if not all(name in self for name in elements):
            return None
        columns = [self._columns[name] for name in elements]
        return self.values[:, columns].reshape(-1, *variable.dimensions)

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def units(self) -> dict[str, str | None]:
        """Unit of each signal; None where its FMU gives none."""
        return {name: self._system.unit(name) for name in self.names}

    def frame(self) -> pd.DataFrame:
        """Return a table with the time (s) as index; ``attrs["units"]`` holds the units."""
        import pandas as pd  # late, for those who start quickly

        index = pd.Index(self.time, name="time")
        frame = pd.DataFrame(self.values, index=index, columns=list(self.names))
        frame.attrs["units"] = self.units
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write ``time`` (s) and the signals, names in the first line, every digit kept."""
        return atomic_write(Path(path), self.frame().to_csv(lineterminator="\n", na_rep="nan"))

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """Write ``time`` (s) and the signals; units are in the metadata of the columns.

        Raises
        ------
        CosimError
            When pyarrow is not installed.
        """
        from stickslip.cosim.signals.tables import write_parquet

        write_parquet(Path(path), self.frame(), self.units)
        return Path(path)

    @cached_property
    def _columns(self) -> dict[str, int]:
        return {name: column for column, name in enumerate(self.names)}
