"""Zip archives: of untrusted ones ``directory`` checks what they say, ``unpacked`` keeps it."""

from stickslip.fmi.archive.packed import zipped
from stickslip.fmi.archive.unpacked import restore, unpack

__all__ = ["restore", "unpack", "zipped"]
