"""The adapter writes messages as printf would."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stickslip import models
from stickslip.fmi import toolchain

ADAPTER = Path(models.__file__).parent / "adapter"
PROBE = """
#include "text.h"
#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
EXPORT void probe(char *out, size_t size, const char *format, ...);
void probe(char *out, size_t size, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    text_write(out, size, format, arguments);
    va_end(arguments);
}
"""


@pytest.fixture(scope="session")
def write() -> Callable[..., str]:
    """Write with the adapter's text.c: ``write("%g s", 1.5)``."""
    files = {name: (ADAPTER / name).read_text() for name in ("text.c", "text.h")}
    library = ctypes.CDLL(str(toolchain.shared_library("text", files | {"probe.c": PROBE})))

    def write(form: str, *values: object, size: int = 200) -> str:
        out = ctypes.create_string_buffer(size)
        library.probe(out, ctypes.c_size_t(size), form.encode(), *values)
        return out.value.decode()

    return write


def test_numbers_look_as_printf_writes_them(write):
    rng = np.random.default_rng(0)
    drawn = rng.standard_normal(2000) * 10.0 ** rng.integers(-300, 300, 2000)
    plain = [0.0, 1.0, -1.5, 5e-4, 0.1, 999999.4, 999999.6, 1e6, 123456789.0, 1e-4, 1e-5, 0.025]
    ends = [1.7976931348623157e308, 5e-324, float("inf"), float("-inf"), float("nan")]
    for value in [*drawn, *ends]:
        written = write("%g", ctypes.c_double(value))
        digits = float(written) / float(f"{value:g}") - 1.0  # the sixth may be one off
        assert written == f"{value:g}" or abs(digits) < 1.1e-5
    for value in plain:
        assert write("%g", ctypes.c_double(value)) == f"{value:g}"


def test_the_other_conversions(write):
    assert write("%s is %d of %d", b"k", -3, 2**31 - 1) == f"k is -3 of {2**31 - 1}"
    most = 2**64 - 1
    assert write("%zu bytes", ctypes.c_size_t(most)) == f"{most} bytes"
    assert write("%lu%s", ctypes.c_ulong(0), b"!") == "0!"


def test_no_more_is_written_than_there_is_room_for(write):
    assert write("%s%g", b"abcdef", ctypes.c_double(1.25), size=8) == "abcdef1"
