"""What to keep of a run: which signals, how often, and what becomes of them on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from stickslip.cosim.errors import ExperimentError


@dataclass(frozen=True)
class Deviation:
    """How far a signal is from a reference over a span, such as a tracking error.

    Attributes
    ----------
    signal : an output, an exposed input or any other real variable
    reference : likewise, or a number in the unit of the signal
    begin, end : points in time count from ``begin`` up to, not including, ``end``, s
    """

    signal: str
    reference: str | float = 0.0
    begin: float = -math.inf
    end: float = math.inf

    @property
    def names(self) -> tuple[str, ...]:
        """Return the signals that it is made of."""
        return (self.signal, self.reference) if isinstance(self.reference, str) else (self.signal,)


@dataclass(frozen=True)
class Record:
    """What to keep of a run.

    >>> Record("drive.*", every=10)
    >>> Record(sum_of_squares={"cost": Deviation("drive.v", "nominal.v_r", begin=0.5)})

    Attributes
    ----------
    names : name or pattern (``drive.*``), or several, of what to keep. A pattern stands for outputs
        and exposed inputs, a name for any variable. Left out, all outputs and exposed inputs
        are kept, or nothing but the sums where there are some. Where no component has an output,
        local variables that can change stand for them. Strings, which are read after each step,
        become ``Result.texts``
    every : keep the points in time 0, every, 2 every, ... only. Where an FMU ends the run, the last
        point is kept as well
    keep : ``all`` these points in time, or the ``last`` point of the run alone
    sum_of_squares : label -> deviation, or a signal whose deviation from 0 is meant. The sum over
        the points in time, taken one after the other, becomes ``Result.sum_of_squares[label]``. It
        needs no trajectory, so that a cost can be had of a run that keeps nothing else

    Raises
    ------
    ExperimentError
        When ``every`` or ``keep`` has another value.
    """

    names: str | Sequence[str] | None = None
    every: int = 1
    keep: Literal["all", "last"] = "all"
    sum_of_squares: Mapping[str, Deviation | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if isinstance(self.every, bool) or not isinstance(self.every, int) or self.every < 1:
            raise ExperimentError(f"record: every = {self.every!r}, expected an integer from 1 on")
        if self.keep not in ("all", "last"):
            raise ExperimentError(f"record: keep = {self.keep!r}, expected 'all' or 'last'")

    @classmethod
    def of(cls, what: Record | str | Sequence[str] | None) -> Record:
        """Return a record as it is, and one of names for names."""
        return what if isinstance(what, Record) else cls(what)

    @property
    def wanted(self) -> tuple[str, ...] | None:
        """Return the names and patterns; None for the usual."""
        if isinstance(self.names, str):
            return (self.names,)
        if self.names is None:
            return () if self.sum_of_squares else None
        return tuple(self.names)

    @property
    def deviations(self) -> dict[str, Deviation]:
        """Return what is squared and summed, by label."""
        return {
            label: Deviation(what) if isinstance(what, str) else what
            for label, what in self.sum_of_squares.items()
        }
