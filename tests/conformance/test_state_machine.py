"""Calls in whatever order, through FMPy, shrunk to the shortest order that breaks a law.

tests/corpus/fuzz_calls gives the same code far more calls, in C; this sees it as packed, by
another tool.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from fmpy.fmi1 import FMICallException
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    invariant,
    rule,
    run_state_machine_as_test,
)

pytestmark = pytest.mark.slow

STEP = 5e-4  # s
CREATED, STARTING, STEPPING, ENDED = "created", "starting", "stepping", "ended"
LEADS = {
    ("setup", CREATED): CREATED,
    ("enter", CREATED): STARTING,
    ("exit", STARTING): STEPPING,
    ("step", STEPPING): STEPPING,
    ("terminate", STEPPING): ENDED,
    **{("reset", phase): CREATED for phase in (CREATED, STARTING, STEPPING, ENDED)},
}
"""The life cycle as both standards draw it; FMI 3.0 has no setup of its own."""
SETTABLE = {
    "input": {CREATED, STARTING, STEPPING},
    "tunable": {CREATED, STARTING, STEPPING},
    "fixed": {CREATED, STARTING},
    "exact": {CREATED, STARTING},
    "": set[str](),
}
"""When a variable may be set: by its causality, as a parameter its variability, or its start."""


class LifeCycle(RuleBasedStateMachine):
    """An instance, and the lawful calls that made it what it is since it was fresh."""

    kept = Bundle("kept")

    def __init__(self, fmu: Any, make: Callable[[], Any], same: Callable[..., bool]) -> None:
        super().__init__()
        self.fmu, self.make, self.same = fmu, make, same
        self.slave = make()
        self.phase, self.past = CREATED, ()
        self.seen = self.slave.everything()

    def attempt(self, what: tuple[str, Any], leads_to: str | None) -> None:
        """Call; an unlawful call is an error that leaves no trace."""
        if leads_to is None:
            with pytest.raises(FMICallException):
                perform(self.slave, *what)
            assert self.same(self.slave.everything(), self.seen)
            return
        perform(self.slave, *what)
        self.phase, self.past = leads_to, (*self.past, what) if what[0] != "reset" else ()
        self.seen = self.slave.everything()

    @rule()
    def onward(self) -> None:
        self.move({CREATED: "enter", STARTING: "exit"}.get(self.phase, "step"))

    @rule(call=st.sampled_from(["setup", "enter", "exit", "step", "terminate", "reset"]))
    def move(self, call: str) -> None:
        if call == "setup" and self.fmu.version == 3:
            return
        time = STEP * sum(name == "step" for name, _ in self.past)
        self.attempt((call, time), LEADS.get((call, self.phase)))

    @rule(data=st.data(), share=st.floats(-1.0, 1.0))
    def set(self, data: st.DataObject, share: float) -> None:
        real = [v for v in self.fmu.variables.values() if v.type in ("Real", "Float64")]
        variable = data.draw(st.sampled_from(real))
        value = float(variable.start or 0.0) + share * float(variable.nominal or 1.0)
        low, high = float(variable.min or -math.inf), float(variable.max or math.inf)
        lawful = self.phase in settable(variable) and low <= value <= high
        self.attempt(("set", {variable.name: value}), self.phase if lawful else None)

    @rule(target=kept)
    def save(self) -> Any:
        return self.slave.api.getFMUState(), self.phase, self.past, self.seen

    @rule(saved=kept, through_bytes=st.booleans())
    def restore(self, saved: Any, through_bytes: bool) -> None:
        state, self.phase, self.past, self.seen = saved
        if through_bytes:
            api = self.slave.api
            state = api.deserializeFMUState(api.serializeFMUState(state))
        self.slave.api.setFMUState(state)

    @invariant()
    def reading_changes_nothing(self) -> None:
        assert self.same(self.slave.everything(), self.seen)

    def teardown(self) -> None:
        """A fresh instance that is given the lawful calls alone ends with the same bits."""
        fresh = self.make()
        for what in self.past:
            perform(fresh, *what)
        assert self.same(fresh.everything(), self.seen)
        for slave in (self.slave, fresh):
            slave.api.freeInstance()


def settable(variable: Any) -> set[str]:
    match variable.causality:
        case "input":
            return SETTABLE["input"]
        case "parameter":
            return SETTABLE[variable.variability]
        case _:
            return SETTABLE["exact" if variable.initial == "exact" else ""]


def perform(slave: Any, call: str, argument: Any) -> None:
    match call:
        case "setup":
            slave.api.setupExperiment(startTime=0.0)
        case "enter":
            slave.api.enterInitializationMode()
        case "exit":
            slave.api.exitInitializationMode()
        case "step":
            slave.api.doStep(argument, STEP)
        case "terminate":
            slave.api.terminate()
        case "reset":
            slave.api.reset()
        case "set":
            slave.set(argument)


def test_no_order_of_calls_breaks_a_law(fmu, slave, identical):
    face = type(slave(fmu))
    run_state_machine_as_test(
        lambda: LifeCycle(fmu, lambda: face(fmu), identical),
        settings=settings(
            max_examples=30,
            stateful_step_count=40,
            deadline=None,
            database=None,
            derandomize=True,
        ),
    )
