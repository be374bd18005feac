"""JSON objects, one a line, as rig and server exchange them (docs/rig.md)."""

import json
import math
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from stickslip.cosim.signals.signals import Array
from stickslip.fmi.files import parse_json
from stickslip.rigs.limits import RigLimits

PROTOCOL = 1
LOOP = ("K_p", "K_i", "tau_f", "m_ff", "K_x", "velocity_feedforward")
"""What a motion says of its velocity loop; units as in ``VelocityLoop``."""
CHUNK = 500  # most samples of a signal in one message
LONGEST = 2**20  # most bytes of a line


def line_of(message: Mapping[str, Any]) -> bytes:
    """Return a message as a line; numbers keep all their bits."""
    return json.dumps(message, allow_nan=False).encode() + b"\n"


def sent_limits(limits: Mapping[str, Any]) -> dict[str, Any]:
    """Return limits by name as a message has them: null for one that is infinite."""

    def sent(value: float) -> float | None:
        return float(value) if math.isfinite(value) else None

    return {
        name: [sent(end) for end in one] if name == "travel" else sent(one)
        for name, one in limits.items()
    }


def received_limits(given: Mapping[str, Any]) -> RigLimits:
    """Return the limits of a message; raise UsageError when one is not a limit."""
    low, high = given["travel"]
    names = [one.name for one in fields(RigLimits) if one.name != "travel"]
    values = {name: math.inf if given[name] is None else float(given[name]) for name in names}
    low, high = (-math.inf if low is None else low), (math.inf if high is None else high)
    return RigLimits((float(low), float(high)), **values)


def crc_of(signals: Mapping[str, Array]) -> int:
    """Return the CRC-32 of signals (n,): little-endian doubles, in the order of their names."""
    crc = 0
    for name in sorted(signals):
        crc = zlib.crc32(np.asarray(signals[name], dtype="<f8").tobytes(), crc)
    return crc


class Lines:
    """Bytes as they arrive, cut into messages."""

    def __init__(self) -> None:
        self._rest = b""

    def messages(self, received: bytes) -> Iterator[dict[str, Any]]:
        """Yield the complete messages; raise ValueError for a line that is too long or none."""
        *lines, self._rest = (self._rest + received).split(b"\n")
        if len(self._rest) > LONGEST:
            raise ValueError(f"a line is longer than {LONGEST} bytes")
        for line in lines:
            message = parse_json(line)
            if not isinstance(message, dict):
                raise ValueError("a line is not a JSON object")  # noqa: TRY004 - what was received
            yield message
