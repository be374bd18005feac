"""The FMUs that represent a drive while its parameters are estimated."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stickslip import models
from stickslip.fmi.process import temporary_folder

CONTROLLER = "velocity_controller"
MODELS = ("compensator", "drive", CONTROLLER)


@contextmanager
def candidate_fmus(law: str = "lugre") -> Iterator[Path]:
    """Build them with a friction law into a folder that is deleted at the end of the block.

    They contain nothing of the drive that made a recording, not even which of its extras are on.
    """
    with temporary_folder() as folder:
        for name in MODELS:
            models.build_fmu(name, folder, law=law if name != CONTROLLER else None)
        yield folder
