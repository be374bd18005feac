"""``--rig``: the drive that a TOML file describes, with limits that abort its motions."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.commandline import add_options
from stickslip.planning import LINEAR, Limits

if TYPE_CHECKING:
    from stickslip.rigs.contract import Rig


MOTIONS = "motions"  # Folder, within that of the results, of the logs of a rig


def add_rig_option(parser: argparse.ArgumentParser, what: str) -> None:
    """Declare ``--rig``."""
    text = f"{what}; --out keeps its logs, and the same command goes on there (docs/rig.md)"
    add_options(parser, {"--rig FILE.toml": text}, type=Path)


@contextmanager
def rig_of(path: Path | None, out: Path | None, law: str) -> Iterator[tuple[Rig | None, Limits]]:
    """Return the rig of a file, whose logs are kept in a folder of results, and its experiment.

    Parameters
    ----------
    path : of the file; None for no rig
    """
    if path is None:
        yield None, LINEAR
        return
    from stickslip.rigs.file import open_rig
    from stickslip.rigs.kept import KeptRig

    rig, limits = open_rig(path, "lugre" if law == "auto" else law)
    with rig:
        yield (KeptRig(rig, out / MOTIONS) if out else rig), limits
