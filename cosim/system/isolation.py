"""What FMUs in a process of their own may take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

from stickslip.cosim.errors import ExperimentError
from stickslip.fmi.process.sandbox import Permissions

_MOST = 1e9
"""Of a time or of memory; 30 years or a petabyte."""


@dataclass(frozen=True)
class Isolation:
    """Run FMUs in a process of their own, within limits.

    Attributes
    ----------
    timeout : s on the clock that preparing, one run or closing may take; any time if None, as long
        as time goes on in the simulation, see ``patience``
    patience : s on the clock that one call before the first step, or one step, may take
    memory : MB (10^6 bytes) that the FMUs may take, on Linux
    allow : what the sandbox lets the FMUs do, on Linux: ``network``, ``exec`` (start programs),
        ``files=DIR`` (read and write all below a folder) and ``env=NAME`` (know a variable)

    Raises
    ------
    ExperimentError
        When one is not positive, or something else is allowed.
    """

    timeout: float | None = None
    patience: float = 30.0
    memory: float = 4096.0
    allow: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("timeout", "patience", "memory"):
            value = getattr(self, name)
            if value is not None and not 0 < value < _MOST:
                most = f" below {_MOST:g}" if value >= _MOST else ""
                raise ExperimentError(
                    f"isolation: {name} is {value}, expected a positive number{most}"
                )
        try:
            Permissions.of(self.allow)
        except ValueError as fault:
            raise ExperimentError(f"isolation: {fault}") from None

    @classmethod
    def of(cls, what: Isolated) -> Self | Isolation | None:
        """Return the settings behind a word.

        Raises
        ------
        ExperimentError
            When the word is unknown.
        """
        if what is None or isinstance(what, Isolation):
            return what
        if what not in ("process", "foreign"):
            raise ExperimentError(
                f"isolation is {what!r}, expected 'foreign', 'process', Isolation() or None"
            )
        return cls()


Isolated = Isolation | Literal["foreign", "process"] | None
"""Which FMUs live in a process of their own: ``process`` and an Isolation mean all and None means
none. ``foreign``, the default, means those systems with an FMU whose binary was not compiled by
this installation, on Linux; a system with Python functions stays in the calling process."""
