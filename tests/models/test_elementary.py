"""Elementary functions against decimal arithmetic; noise; messages written as by printf."""

import ctypes
import math
from collections.abc import Callable
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

from stickslip import models
from stickslip.fmi import toolchain
from tests.corpus.fmu import EXPORT

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620900")


def exact(function: Callable[[Decimal], Decimal], x: np.ndarray) -> list[Decimal]:
    with localcontext() as context:
        context.prec = 60
        return [function(Decimal(float(value))) for value in x]


def relative_error(y: np.ndarray, truth: list[Decimal]) -> float:
    """Return the largest error relative to the truth."""
    with localcontext() as context:
        context.prec = 60
        return max(
            float(abs((Decimal(float(a)) - b) / b)) for a, b in zip(y, truth, strict=True) if b
        )


def sine(x: Decimal) -> Decimal:
    half_turns = (x / PI).to_integral_value()
    r = x - half_turns * PI
    term = total = r
    for k in range(1, 25):
        term *= -r * r / (2 * k * (2 * k + 1))
        total += term
    return -total if half_turns % 2 else total


def phi(y: Decimal) -> Decimal:
    return (1 - (-y).exp()) / y


def phi2(y: Decimal) -> Decimal:
    return (1 - phi(y)) / y


RANDOM = np.random.default_rng(1)
POSITIVE = 10.0 ** RANDOM.uniform(-12, 4, 3000)
AROUND_A_HALF = np.nextafter(0.5, [0.0, 1.0, 0.5])

CASES = {
    "exp": (lambda x: x.exp(), RANDOM.uniform(-700, 700, 3000), 3e-16),
    "exp near 0": (lambda x: x.exp(), RANDOM.uniform(-2, 2, 3000), 3e-16),
    "log": (lambda x: x.ln(), 10.0 ** RANDOM.uniform(-300, 300, 3000), 3e-16),
    "log near 1": (lambda x: x.ln(), RANDOM.uniform(0.6, 1.6, 3000), 3e-16),
    "sin": (sine, RANDOM.uniform(-10, 10, 3000), 3e-16),
    "sin far out": (sine, RANDOM.uniform(-1e5, 1e5, 3000), 3e-16),
    "phi": (phi, np.concatenate([POSITIVE, AROUND_A_HALF]), 5e-16),
    "phi2": (phi2, np.concatenate([POSITIVE, AROUND_A_HALF]), 2e-15),
}


@pytest.mark.parametrize("case", CASES)
def test_relative_error_is_in_the_last_bits(c, case):
    function, x, bound = CASES[case]
    assert relative_error(c(case.split()[0], x), exact(function, x)) < bound


@pytest.mark.parametrize(
    ("name", "x", "y"),
    [
        ("exp", 0.0, 1.0), ("exp", -708.5, 0.0), ("exp", -math.inf, 0.0), ("log", 1.0, 0.0),
        ("sin", 0.0, 0.0), ("phi", 0.0, 1.0), ("phi2", 0.0, 0.5),
        *((name, math.nan, math.nan) for name in ("exp", "phi", "phi2")),
    ],
)  # fmt: skip
def test_special_values_are_exact(c, name, x, y):
    np.testing.assert_array_equal(c(name, np.array([x])), y)
    assert np.isfinite(c("exp", np.array([709.0, 1e4, math.inf]))).all()


N = 100_000


@pytest.fixture
def draw(library: ctypes.CDLL) -> Callable[..., np.ndarray]:
    def draw(seed: int = 0, channel: int = 0, n: int = N) -> np.ndarray:
        y = np.empty(n)
        library.probe_noise(
            ctypes.c_size_t(n), ctypes.c_double(seed), channel, y.ctypes.data_as(ctypes.c_void_p)
        )
        return y

    return draw


def test_bell_shape(draw):
    """Twelve uniforms summed: no skew, kurtosis 3 - 1.2 / 12, and 68.3 % within one deviation."""
    y = draw()
    assert abs((y**3).mean()) < 5 * np.sqrt(15 / N)
    assert abs((y**4).mean() - 2.9) < 5 * np.sqrt(96 / N)
    assert abs((np.abs(y) < 1).mean() - 0.6785) < 0.01
    assert np.abs(y).max() <= 6


@pytest.mark.parametrize("other", [{"seed": 1}, {"channel": 1}, {"seed": 2**31 - 1}])
def test_seeds_and_channels_are_independent(draw, other):
    y, z = draw(), draw(**other)
    assert abs(np.corrcoef(y, z)[0, 1]) < 5 / np.sqrt(N)


def test_draws_are_independent_of_those_before(draw):
    y = draw(3)
    for lag in (1, 2, 7):
        assert abs(np.corrcoef(y[:-lag], y[lag:])[0, 1]) < 5 / np.sqrt(N)


ADAPTER = Path(models.__file__).parent / "adapter"
PROBE = f"""{EXPORT}
#include "text.h"
EXPORT void probe(char *out, size_t size, const char *format, ...);
void probe(char *out, size_t size, const char *format, ...) {{
    va_list arguments;
    va_start(arguments, format);
    text_write(out, size, format, arguments);
    va_end(arguments);
}}
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
