"""A simulation is used by one thread of one process; simulations of their own run side by side."""

import copy
import os
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import joined

STEP, STOP = 1e-3, 20.0
forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
silent = pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")


@pytest.fixture
def system(make):
    parts = {"a": make("integrator", 2), "b": make("gain", 3)}
    return joined(parts, "a.y b.u", name="shared", u="a.u")


@pytest.mark.parametrize(("isolation", "n"), [(None, 4), ("process", 2)])
def test_threads_get_their_own_result_or_one_line(system, isolation, n):
    gate = threading.Barrier(n)
    with system.prepare(step=STEP, stop=STOP, isolation=isolation) as simulation:
        expected = {k: simulation.run({"b.k": k}).values for k in range(n)}

        def run(k):
            gate.wait()
            found = []
            for _ in range(20):
                try:
                    found.append(simulation.run({"b.k": k}).values)
                except cosim.SharedSimulation as error:
                    found.append(str(error))
            return k, found

        with ThreadPoolExecutor(n) as pool:
            answers = dict(pool.map(run, range(n)))
        for k, found in answers.items():
            for answer in found:
                if isinstance(answer, str):
                    assert "one thread at a time" in answer
                    assert "simulation.spec.prepare()" in answer
                else:
                    np.testing.assert_array_equal(answer, expected[k])
        np.testing.assert_array_equal(simulation.run({"b.k": 1.0}).values, expected[1])


@pytest.mark.parametrize("isolation", [None, "process"])
def test_while_it_runs_it_is_not_closed_or_saved(system, tmp_path, isolation):
    with system.prepare(step=STEP, stop=STOP, isolation=isolation) as simulation:
        for call in (simulation.run, simulation.close, lambda: simulation.save(tmp_path / "s")):
            refused = []

            def look(_, call=call, refused=refused):
                with pytest.raises(cosim.SharedSimulation, match="shared: "):
                    call()
                refused.append(call)

            result = simulation.run({"b.k": 2.0}, {"u": 1.0}, progress=look)
            assert refused
            assert result["b.y"][-1] == pytest.approx(2.0 * (1.0 + STOP))


def in_a_fork(do):
    """Return what a forked process makes of a call, as text."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            answer = str(do())
        except BaseException as error:  # noqa: BLE001 - told to the parent
            answer = f"{type(error).__name__}: {error}"
        os.write(writing, answer.encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        answer = pipe.read()
    assert os.waitpid(child, 0)[1] == 0
    return answer


@forks
@silent
def test_after_a_fork_an_isolated_one_belongs_to_the_parent(system, tmp_path):
    with system.prepare(step=STEP, stop=1.0, isolation="process") as simulation:
        expected = simulation.run({"b.k": 2.0}, {"u": 1.0}, until=0.5)
        for do in (simulation.run, lambda: simulation.save(tmp_path / "state")):
            answer = in_a_fork(do)
            assert answer.startswith(
                "SharedSimulation: shared: this simulation was prepared before"
            )
            assert "simulation.spec.prepare()" in answer
        assert in_a_fork(simulation.close) == "None"  # without harm
        again = simulation.run({"b.k": 2.0}, {"u": 1.0}, until=0.5)
        np.testing.assert_array_equal(again.values, expected.values)

        def another():
            return simulation.spec.prepare().run({"b.k": 2.0}, {"u": 1.0})["b.y"][-1]

        assert float(in_a_fork(another)) == pytest.approx(4.0)


@pytest.mark.parametrize("isolation", [None, "process"])
def test_pickling_says_what_to_do_instead(system, isolation):
    with system.prepare(step=STEP, stop=1.0, isolation=isolation) as simulation:
        for do in (pickle.dumps, copy.copy, copy.deepcopy):
            with pytest.raises(TypeError, match=r"pickle simulation\.spec, and prepare\(\) it"):
                do(simulation)
        expected = simulation.run().values
        spec = pickle.loads(pickle.dumps(simulation.spec))  # noqa: S301 - our own bytes
        with spec.prepare() as arrived:
            np.testing.assert_array_equal(arrived.run().values, expected)
