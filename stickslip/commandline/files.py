"""Files of a command."""

from collections.abc import Mapping
from pathlib import Path

from stickslip.fmi.files import atomic_write
from stickslip.storage import staged


def write_files(out: Path | None, command: Mapping[str, object], files: Mapping[str, str]) -> None:
    """Write texts by file name into a folder of results, if there is one, and print their paths."""
    if out is None:
        return
    with staged(out, command) as staging:
        for name, text in files.items():
            atomic_write(staging / name, text)
    print(*(out / name for name in files), sep="\n")
