from __future__ import annotations

import gc
import signal
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim


@pytest.fixture
def oscillator(make):
    """x'' = -x, x(0) = 1: a gain and two integrators in a ring."""
    system = cosim.System("oscillator")
    system.add("spring", make("gain", 2), {"k": -1.0})
    system.add("speed", make("integrator", 3), {"k": 0.0})
    system.add("position", make("integrator", 2), {"k": 1.0})
    system.connect("position.y", "spring.u")
    system.connect("spring.y", "speed.u")
    system.connect("speed.y", "position.u")
    return system


def test_a_chain_passes_values_on_within_the_step(make):
    system = cosim.System("chain")
    for name in ("last", "middle", "first"):
        system.add(name, make("gain"), {"k": 2.0})
    system.connect("first.y", "middle.u")
    system.connect("middle.y", "last.u")
    system.expose("u", "first.u")
    u = np.arange(6.0)
    with system.prepare(step=1.0, stop=5.0) as simulation:
        result = simulation.run(inputs={"u": u})
    assert simulation.order == ["first", "middle", "last"]
    np.testing.assert_array_equal(result["u"], u)
    # the value of u at t[n] holds from t[n] to t[n + 1]
    np.testing.assert_array_equal(result["last.y"][1:], 8 * u[:-1])
    assert result["last.y"][0] == 8 * u[0]
    result = system.prepare(step=1.0, stop=5.0, coupling="jacobi").run(inputs={"u": u})
    np.testing.assert_array_equal(result["last.y"][3:], 8 * u[:-3])


def test_an_exposed_input_may_share_the_name_of_a_component(make):
    system = cosim.System()
    system.add("u", make("gain"))
    system.add("b", make("gain"))
    system.expose("u", "b.u")
    u = np.arange(4.0)
    result = system.prepare(step=1.0, stop=3.0).run(inputs={"u": u})
    np.testing.assert_array_equal(result["b.y"][1:], u[:-1])


def test_an_input_left_out_keeps_its_start_value(make):
    system = cosim.System()
    system.add("a", make("gain"), {"u": 5.0})
    system.expose("u", "a.u")
    assert set(system.prepare(step=0.1, stop=1.0).run()["a.y"]) == {5.0}
    assert set(system.prepare(step=0.1, stop=1.0).run({"a.u": 7.0})["a.y"]) == {7.0}


def test_a_changed_system_does_not_change_what_was_prepared(oscillator):
    simulation = oscillator.prepare(step=1e-2, stop=1.0)
    before = simulation.run().values
    oscillator.set("spring.k", -9.0)
    np.testing.assert_array_equal(simulation.run().values, before)


def test_steps_longer_than_a_block_and_a_start_that_is_not_zero(make):
    system = cosim.System()
    system.add("x", make("integrator"), {"k": 0.0, "u": 2.0})
    simulation = system.prepare(step=0.25, stop=1000.0, start=100.0)
    result = simulation.run()
    np.testing.assert_array_equal(result["x.y"], 2.0 * (result.time - 100.0))
    subset = system.prepare(step=0.25, stop=1000.0, start=100.0, record=["x.y"]).run()
    np.testing.assert_array_equal(subset["x.y"], result["x.y"])


@pytest.mark.parametrize("wanted", ["spring.yy", "nothing.*", "sprint.y"])
def test_what_cannot_be_recorded_is_named(oscillator, wanted):
    with pytest.raises(cosim.ConnectionFault, match="cannot record"):
        oscillator.prepare(step=0.1, stop=1.0, record=[wanted])


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs POSIX timers")
def test_an_interrupt_ends_a_run_within_about_a_second(make):
    system = cosim.System()
    for i in range(200):
        system.add(f"x{i}", make("integrator"), {"u": 1.0})

    def interrupt(*_):
        raise KeyboardInterrupt

    simulation = system.prepare(step=1e-6, stop=3.0, record=["x0.y"])
    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(KeyboardInterrupt):
            simulation.run()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.slow
def test_many_runs_leave_memory_and_open_files_as_they_were(oscillator):
    def resources():
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]), len(
            list(Path("/proc/self/fd").iterdir())
        )

    if not Path("/proc/self/statm").exists():
        pytest.skip("needs /proc")
    with oscillator.prepare(step=0.1, stop=1.0) as simulation:
        for k in np.linspace(-1, 0, 200):
            simulation.run({"spring.k": k})
        pages, files = resources()
        for k in np.linspace(-1, 0, 5000):
            simulation.run({"spring.k": k})
            simulation.run()
    for _ in range(50):
        oscillator.prepare(step=0.1, stop=1.0).close()
    assert resources()[1] == files
    assert resources()[0] - pages < 100
