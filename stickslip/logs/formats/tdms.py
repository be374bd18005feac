"""Logs as TDMS files of LabVIEW and its relatives."""

import io
from typing import Any

import numpy as np

TITLE = "TDMS"
SUFFIXES = (".tdms",)
BEGINS = (b"TDSm",)
NEEDS = ("nptdms", "tdms")


def contents(data: bytes) -> list[dict[str, Any]]:
    """Return the channels with their units, and their times where the file states the period."""
    from nptdms import TdmsFile

    file = TdmsFile.read(io.BytesIO(data))
    if file.file_status.incomplete_final_segment:
        raise ValueError("the last segment is cut off")
    channels = []
    for group in file.groups():
        for channel in group.channels():
            each = {"name": channel.name, "values": channel[:]}
            each["unit"] = str(channel.properties.get("unit_string", ""))
            if period := float(channel.properties.get("wf_increment", 0.0)):
                begin = float(channel.properties.get("wf_start_offset", 0.0))
                each["time"] = begin + np.arange(len(channel)) * period
            channels.append(each)
    return channels
