"""Rules about Model Exchange."""

import itertools
import math
from collections.abc import Iterator
from ctypes import byref, c_double, c_size_t

from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import status_name
from stickslip.fmucheck.running.run import STEPS, ExchangeRun, indicator_count, new_run

_GUARD = -1.2345678e-300  # what nothing computes
_SPARE = 4


def _begun(bench: Bench) -> Iterator[ExchangeRun]:
    """Yield a run of Model Exchange that has begun, if there is one."""
    run = new_run(bench) if bench.is_exchange else None
    if isinstance(run, ExchangeRun):
        run.begin()
        if not run.ended:
            yield run


@error("3.2.2", "2.3.2", "count them alike in code and description")
def wrong_count(bench: Bench) -> Claims:
    """The number of states or event indicators is not that of the description."""
    for run in _begun(bench):
        three = bench.description.version == 3
        states = bench.description.count(bench.description.states)
        wanted = {"ContinuousStates": states, "EventIndicators": indicator_count(bench.description)}
        for name, count in wanted.items():
            if three:
                found = c_size_t()
                status = run.instance.status(f"GetNumberOf{name}", byref(found))
                if status > 1 or found.value != count:
                    count_found = found.value if status <= 1 else status_name(status)
                    yield name, f"the binary has {count_found}, the description {count}"
            array = (c_double * (count + _SPARE))(*[_GUARD] * (count + _SPARE))
            failed = run.instance.status(f"Get{name}", array, c_size_t(count)) > 1
            if failed and count:  # without any, nobody has to call it
                yield name, f"cannot be got as {count} values"
                run.instance.broken = True
                return
            if any(x != _GUARD for x in array[count:]):
                yield name, f"more than {count} values are written"
            elif any(x == _GUARD for x in array[:count]):
                yield name, f"fewer than {count} values are written"


@error("3.2.2", "3.2", "find the division by 0 or missing start")
def derivative_not_finite(bench: Bench) -> Claims:
    """A derivative or event indicator is infinite or not a number."""
    for run, _ in itertools.product(_begun(bench), range(STEPS)):
        if run.ended:
            return
        for name, values in (("derivatives", run.rates()), ("indicators", run.indicators())):
            if not all(math.isfinite(x) for x in values):
                yield name, f"{values} at t = {run.time}"
                return
        run.go(1)


@error("3.2.1", "3.2", "store what is set")
def state_not_set(bench: Bench) -> Claims:
    """Continuous states that are set are not those that are got back."""
    for run in _begun(bench):
        wanted = [x + 0.001 * (1 + abs(x)) for x in run.states()]
        run.instance.set_states(wanted)
        if run.states() != wanted:
            yield "SetContinuousStates", f"were set to {wanted[:5]}, are {run.states()[:5]}"


@error("3.2.1", "3.2", "compute derivatives from what is set, no memory")
def rates_depend_on_history(bench: Bench) -> Claims:
    """Derivatives at the same time and state differ after the solver tried another point."""
    for run in _begun(bench):
        run.go(2)
        if run.ended:
            return
        x, before = run.states(), repr(run.rates())
        time = run.time
        run.instance.do("SetTime", c_double(time + 0.01 * bench.step_size))
        run.instance.set_states([a + 1e-3 * (1 + abs(a)) for a in x])
        run.rates()
        run.instance.do("SetTime", c_double(time))
        run.instance.set_states(x)
        if repr(run.rates()) != before:
            yield "derivatives", f"are no longer the same at t = {time}"


@warning("3.2.2", "3.2", "give each state its usual size")
def bad_state_nominal(bench: Bench) -> Claims:
    """The nominal value of a state, as the binary tells it, is 0, negative or not finite."""
    for run in _begun(bench):
        for v, x in zip(bench.description.states, run.nominals, strict=False):
            if not (x > 0.0 and math.isfinite(x)):
                yield v.place, f"nominal {x}"
