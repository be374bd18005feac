"""Logs as MDF files: MF4, and version 3."""

import io
from typing import Any

TITLE = "MDF"
SUFFIXES = (".mf4", ".mdf")
BEGINS = (b"MDF     ", b"UnFinMF ")
NEEDS = ("asammdf", "mdf")


def contents(data: bytes) -> list[dict[str, Any]]:
    """Return the channels as physical values, with their units and times."""
    from asammdf import MDF

    with MDF(io.BytesIO(data)) as file:
        return [
            {
                "name": signal.name,
                "values": signal.samples,
                "unit": signal.unit or "",
                "time": signal.timestamps,
            }
            for signal in file.iter_channels(skip_master=True)
        ]
