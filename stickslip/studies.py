"""What a reproduction is compared with: the same paper on other drives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import ga
from stickslip.execution import Execution
from stickslip.extras import Extras, all_effects
from stickslip.reproduction import Options, Progress, Reproduction, reproduce
from toolchain import Fault


def with_studies(
    reproduction: Reproduction, fmus: Path, progress: Progress, execution: Execution
) -> Reproduction:
    """Return a reproduction with what is compared with it.

    Parameters
    ----------
    fmus : folder of its FMUs
    execution : its checkpoint is left as it is
    """
    extras = reproduce_with_extras(reproduction.options, fmus / "extras", progress, execution)
    return replace(reproduction, extras=extras)


def reproduce_with_extras(
    options: Options, fmus: Path, progress: Progress, execution: Execution
) -> Extras:
    """Identify, learn and validate on the drive with all effects on; ``fmus`` is made."""
    fmus.mkdir()
    try:
        found = reproduce(
            replace(options, truth={**options.truth, **all_effects()}),
            fmus,
            _Named(progress),
            replace(execution, checkpoint=None, resume=False),
        )
    except ga.Interrupted:  # its message is that of a search without a checkpoint
        raise KeyboardInterrupt from None
    except Fault as fault:
        return Extras(None, str(fault))
    return Extras(found.validation)


@dataclass(frozen=True)
class _Named:
    """Tells stages with the drive that they are of."""

    progress: Progress

    def stage(self, name: str) -> None:
        self.progress.stage(f"all extras on: {name}")

    def generation(self, algorithm: ga.Optimiser) -> None:
        self.progress.generation(algorithm)
