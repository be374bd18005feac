"""What an FMU does to rounding and to numbers near zero, it does to itself alone."""

import ctypes
import subprocess
import sys

import fmpy
import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.kernel import plain_arithmetic
from tests.corpus.hostile import fmus
from tests.cosim.single import joined, one
from tests.kept import further

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="hostile.c is for Linux")

CHANGES = ["round", "round_down", "round_to_zero", "flush", "flush_results", "flush_operands"]
CALLS = ["load", "Instantiate", "EnterInitializationMode", "ExitInitializationMode"]
CALLS += ["SetReal 1", "SetReal 20", "DoStep 2", "GetReal 20", "Terminate", "FreeInstance"]
TINY = {"k": 1.1e-308}  # a step adds a hundredth of it, which is subnormal


def is_plain() -> bool:
    """Sums and products of this thread, computed by C and by Python."""
    unit, small, subnormal = np.float64([1.0, 1e-30, 1e-310])
    rounds = unit + small == 1.0 and unit - small == 1.0 and float(unit) + float(small) == 1.0
    return bool(rounds and subnormal * 0.5 > 0.0 and float(subnormal) + float(subnormal) > 0.0)


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return fmus.write(tmp_path_factory.mktemp("sound") / "sound.fmu")


@pytest.fixture(scope="module")
def expected(sound):
    """The outputs of those that compute, when each is alone."""
    values = {}
    for name in ("plain", "tiny"):
        system = one(sound, {"k": 1 / 3} if name == "plain" else TINY, name=name)
        values[name] = run(system)[0][f"{name}.y"].tobytes()
    assert 0.0 < np.frombuffer(values["tiny"])[1] < sys.float_info.min
    return values


def run(system, **how):
    with system.prepare(step=0.01, stop=1.0, **how) as simulation:
        results = [simulation.run(), simulation.run()]
    assert is_plain()
    return results


def pair(changer, sound):
    """Return a system of one FMU that may change the arithmetic and two that compute."""
    return joined({"changer": changer, "plain": (sound, {"k": 1 / 3}), "tiny": (sound, TINY)})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "change"),
    [*((call, "round") for call in CALLS), *(("DoStep 2", change) for change in CHANGES[1:])],
)
def test_the_others_compute_as_if_they_were_alone(tmp_path, sound, expected, call, change):
    words = call.split()
    behaviour = " ".join([words[0], change, *words[1:]])
    for i, coupling in enumerate(["gauss_seidel", "jacobi", cosim.Coupling(degree=1)]):
        changer = fmus.write(tmp_path / f"{i}.fmu", behaviour, version=2 + i % 2)
        for result in run(pair(changer, sound), coupling=coupling):
            assert {name: result[f"{name}.y"].tobytes() for name in expected} == expected


@pytest.mark.parametrize("change", ["round", "flush"])
@pytest.mark.parametrize("how", [{"compiled": True}, {"isolation": "process"}])
def test_so_it_is_compiled_or_apart(tmp_path, sound, expected, change, how):
    changer = fmus.write(tmp_path / "changer.fmu", f"DoStep {change} 2")
    for result in run(pair(changer, sound), **how):
        assert {name: result[f"{name}.y"].tobytes() for name in expected} == expected


@pytest.mark.parametrize(
    ("call", "change"), [("DoStep", "round"), *further(("load", "round"), ("Instantiate", "flush"))]
)
def test_so_it_is_in_one_fmu(tmp_path, sound, expected, change, call):
    """A container, in a process of its own: FMPy loads libraries for good."""
    changer = fmus.write(tmp_path / "changer.fmu", f"{call} {change}")
    path = cosim.write_fmu(pair(changer, sound), tmp_path / "packed.fmu", step=0.01)
    script = f"""
import fmpy, sys
result = fmpy.simulate_fmu({str(path)!r}, stop_time=1.0, output_interval=0.01, step_size=0.01)
assert 1.0 + 1e-30 == 1.0 and 1e-310 * 0.5 > 0.0, "ours has changed"
print(result["plain.y"].tobytes().hex(), result["tiny.y"].tobytes().hex())
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert [bytes.fromhex(values) for values in done.stdout.split()] == [*expected.values()]


def test_a_caller_keeps_an_arithmetic_of_his_own(sound, expected):
    """Runs do not depend on it, and it is there again afterwards."""
    libm = ctypes.CDLL("libm.so.6")
    before = libm.fegetround()
    system = one(sound, {"k": 1 / 3}, name="plain")
    upward = 0x800 if fmpy.platform == "linux64" else 0x400000  # FE_UPWARD of x86-64 and of arm64
    libm.fesetround(upward)
    try:
        with system.prepare(step=0.01, stop=1.0) as simulation:
            values = simulation.run()["plain.y"]
            with plain_arithmetic():
                inside = libm.fegetround()
            after = libm.fegetround()
    finally:
        libm.fesetround(before)
    assert (inside, after) == (before, upward)
    assert values.tobytes() == expected["plain"]
