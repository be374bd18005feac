"""On the general path, too: steps after a restore equal the steps after the save."""

from __future__ import annotations

import ctypes

import pytest

from stickslip.cosim import kernel
from tests.cosim.single import one

FLAG = {2: 'canGetAndSetFMUstate="true"', 3: 'canGetAndSetFMUState="true"'}


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("interface", ["model_exchange", "co_simulation"])
def test_restored_steps_equal_the_saved(export, version, interface):
    system = one(export("ball", version, "ME CS events", FLAG[version]), interface=interface)
    assert system.components["a"].restores_state
    simulation = system.prepare(step=0.1, stop=1.0, tolerance=1e-8)
    simulation.run()
    save, restore, free = (
        ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(address)
        for address in simulation._general_components["a"].state_calls()
    )
    instance = simulation._slots["a"].instance
    step, get = kernel.load().general_DoStep, kernel.load().general_GetReal
    state, value = ctypes.c_void_p(), ctypes.c_double()

    def heights():
        for n in range(5):
            t = ctypes.c_double(1.0 + 0.1 * n)
            assert step(ctypes.c_void_p(instance), t, ctypes.c_double(0.1), 1) == 0
            place = (ctypes.c_uint32 * 1)(1)
            get(ctypes.c_void_p(instance), place, ctypes.c_size_t(1), ctypes.byref(value))
            yield value.value

    assert save(instance, ctypes.byref(state)) == 0
    first = list(heights())
    assert restore(instance, state) == 0
    second = list(heights())
    assert free(instance, ctypes.byref(state)) == 0
    assert state.value is None
    assert len(set(first)) == 5
    assert first == pytest.approx(second, abs=1e-6 if interface == "model_exchange" else 0)
