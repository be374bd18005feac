"""The usual arithmetic during calls of an FMU that the kernel does not make."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import byref

from stickslip.cosim import kernel
from stickslip.cosim.kernel.structures import Arithmetic


@contextmanager
def plain_arithmetic() -> Iterator[None]:
    """Let FMUs begin with the usual arithmetic, and have ours back afterwards.

    The usual arithmetic rounds to nearest and keeps subnormal numbers. Also a decorator.
    """
    library, before = kernel.load(), Arithmetic()
    library.begin_plain_arithmetic(byref(before))
    try:
        yield
    finally:
        library.end_plain_arithmetic(byref(before))
