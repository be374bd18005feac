"""Standard streams, also where whoever started the process has closed them."""

from __future__ import annotations

import os
import sys
from io import TextIOWrapper


def open_standard_streams() -> None:
    """Open the null device in the place of each standard stream that is closed.

    A file that is opened later would else get the stream's number, and what is printed or read by
    that number would go into it or come out of it. Characters that the encoding of an output lacks
    are printed by their number, such as U+00E4, as escapes.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
            os.set_inheritable(number, True)
        if getattr(sys, name) is None:
            mode = "w" if number else "r"
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
