"""Threads and processes: the same bytes, also when workers die."""

import importlib.util
import multiprocessing
import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from problems import GENES, KillsItsWorker, quadratic, sometimes_fails

from stickslip import ga
from stickslip.ga.execution.evaluation import DIED

GENERATIONS = 4


def history(cost, executor=None):
    optimiser = ga.optimiser("default", ga.Problem(GENES), ga.Limits(generations=GENERATIONS))
    ga.learn(optimiser, cost, executor)
    return optimiser.history


@pytest.fixture(scope="module")
def processes():
    with ga.executor("processes", 2) as executor:
        yield executor


def test_serial_threads_and_processes_agree_bit_for_bit(processes):
    serial = history(sometimes_fails).to_csv()
    with ga.executor("threads", 2) as threads:
        assert history(sometimes_fails, threads).to_csv() == serial
    assert history(sometimes_fails, processes).to_csv() == serial


def test_a_worker_that_dies_takes_no_result_with_it(processes, tmp_path):
    once = tmp_path / "once"
    once.touch()
    died = history(KillsItsWorker(os.getpid(), once=once), processes)
    assert not once.exists()
    assert died.to_csv() == history(quadratic).to_csv()


@pytest.mark.slow
def test_a_candidate_that_kills_its_worker_costs_infinity(processes):
    costs = history(quadratic)["a"]
    limit = float(np.sort(costs)[-2])  # one candidate is above, in one of the generations
    killed = history(KillsItsWorker(os.getpid(), limit), processes)
    failed = killed[killed["a"] > limit]
    assert len(failed) >= 1
    assert (failed["cost"] == np.inf).all()
    assert (failed["reason"] == DIED).all()
    assert np.isfinite(killed[killed["a"] <= limit]["cost"]).all()


def test_a_single_thread_is_the_callers_own():
    with ga.executor("threads", 1) as executor:
        assert executor is None


@pytest.mark.parametrize(
    ("where", "workers", "message"),
    [
        ("threads", 0, "at least 1, got 0"),
        ("greenlets", 2, "no workers 'greenlets'"),
        ("tcp://", 2, "no workers 'tcp://'; expected threads or processes"),
    ],
)
def test_a_place_that_cannot_be_is_named(where, workers, message):
    with pytest.raises(ga.SettingsError, match=message), ga.executor(where, workers):
        pass


def test_a_cost_that_does_not_pickle_is_named(processes):
    lock = threading.Lock()
    with pytest.raises(ga.SettingsError, match=r"cannot be sent to another process \(.*lock"):
        history(lambda values: float(values.sum()) + lock.locked(), processes)


def test_functions_of_modules_that_cannot_be_imported_are_sent_whole(processes, tmp_path):
    path = tmp_path / "hidden.py"
    path.write_text("TIMES = 3.0\ndef cost(values):\n    return TIMES * float(values.sum())\n")
    spec = importlib.util.spec_from_file_location("hidden", path)
    hidden = sys.modules["hidden"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(hidden)
    assert history(hidden.cost, processes).equals(history(lambda x: 3.0 * float(x.sum())))


SCRIPT = """
from pathlib import Path
from stickslip import ga

Path("begun").open("a").write("x")

class Odd(Exception): ...

def cost(values):
    if aim < 0.0:
        raise Odd(aim)
    return float((values[0] - aim) ** 2)

problem, limits = ga.Problem([ga.Gene("a", 0.1, 8.0, 1.0, "")]), ga.Limits(generations=2)
with ga.executor("processes", 1) as executor:
    for aim in (2.0, -1.0):
        try:
            found = ga.learn(ga.optimiser("default", problem, limits), cost, executor)
        except Odd as odd:
            print(odd, end="")
        else:
            print(found.best.cost < 1.0, end=" ")
"""


@pytest.mark.parametrize("arguments", [["script.py"], ["-"]])
def test_a_script_without_a_guard_runs_once_and_its_functions_in_workers(arguments, tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    run = subprocess.run(
        [sys.executable, *arguments],
        cwd=tmp_path,
        input=SCRIPT,
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert (run.stdout, run.stderr) == ("True -1.0", "")
    assert (tmp_path / "begun").read_text() == "x"


def test_a_process_that_may_have_no_children_says_so(monkeypatch):
    monkeypatch.setitem(multiprocessing.current_process()._config, "daemon", True)
    message = "cannot be started: daemonic .*; use threads"
    with pytest.raises(ga.SettingsError, match=message), ga.executor("processes", 1) as executor:
        history(quadratic, executor)
