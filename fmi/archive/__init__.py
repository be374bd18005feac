"""Untrusted zip archives: ``directory`` checks what one says of itself, ``unpacked`` keeps it."""

from stickslip.fmi.archive.unpacked import restore, unpack

__all__ = ["restore", "unpack"]
