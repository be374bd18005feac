"""Threads, processes and Dask: the same bytes, also when workers die."""

import asyncio
import importlib.util
import multiprocessing
import os
import socket
import subprocess
import sys
import threading
import weakref
from functools import partial

import numpy as np
import pytest
from problems import GENES, KillsItsWorker, quadratic, sometimes_fails

from stickslip import ga
from stickslip.ga.execution.evaluation import DIED, Packed
from tests.kept import further

GENERATIONS = 4


def history(cost, executor=None):
    optimiser = ga.optimiser("default", ga.Problem(GENES), ga.Limits(generations=GENERATIONS))
    ga.learn(optimiser, cost, executor)
    return optimiser.history


@pytest.fixture(scope="module")
def processes():
    with ga.executor("processes", 2) as executor:
        yield executor


@pytest.fixture(scope="module")
def cluster():
    dask = pytest.importorskip("dask")
    distributed = pytest.importorskip("distributed")
    with (
        dask.config.set(
            {
                "distributed.scheduler.allowed-failures": 0,
                "distributed.worker.daemon": True,
                "distributed.logging.distributed": "critical",
            }
        ),
        distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=":0") as local,
        ga.executor(local.scheduler_address) as executor,
    ):
        yield executor


@pytest.fixture(params=["processes", "cluster"])
def apart(request):
    """Workers that are processes of their own."""
    return request.getfixturevalue(request.param)


def test_serial_threads_processes_and_dask_agree_bit_for_bit(apart):
    serial = history(sometimes_fails).to_csv()
    with ga.executor("threads", 2) as threads:
        assert history(sometimes_fails, threads).to_csv() == serial
    assert history(sometimes_fails, apart).to_csv() == serial


def test_a_worker_that_dies_takes_no_result_with_it(apart, tmp_path):
    once = tmp_path / "once"
    once.touch()
    died = history(KillsItsWorker(os.getpid(), once=once), apart)
    assert not once.exists()
    assert died.to_csv() == history(quadratic).to_csv()


@pytest.mark.slow
def test_a_candidate_that_kills_its_worker_costs_infinity(apart):
    costs = history(quadratic)["a"]
    limit = float(np.sort(costs)[-2])  # one candidate is above, in one of the generations
    killed = history(KillsItsWorker(os.getpid(), limit), apart)
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
        ("tcp://", 2, "no Dask scheduler at 'tcp://'"),
        ("http://127.0.0.1:1", 2, "no Dask scheduler at 'http"),
    ],
)
def test_a_place_that_cannot_be_is_named(where, workers, message):
    with pytest.raises(ga.SettingsError, match=message), ga.executor(where, workers):
        pass


def test_no_client_is_begun_where_no_scheduler_answers(cluster, monkeypatch):
    """A client that fails would be closed by the garbage collector, in whatever thread it runs."""
    import dask
    import distributed

    monkeypatch.setattr(distributed, "Client", None)
    worker = next(iter(cluster._client.ncores()))
    with pytest.raises(ga.SettingsError, match="there is a "), ga.executor(worker, 2):
        pass
    with (
        socket.create_server(("127.0.0.1", 0)) as silent,
        dask.config.set({"distributed.comm.timeouts.connect": "200ms"}),
        pytest.raises(ga.SettingsError, match=r"timed out after 0\.2 s"),
        ga.executor(f"tcp://127.0.0.1:{silent.getsockname()[1]}", 2),
    ):
        pass


def test_what_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr("stickslip.ga.execution.cluster.find_spec", lambda _: None)
    needed = r"distributed.*\[dask\]"
    with pytest.raises(ga.SettingsError, match=needed), ga.executor("tcp://10.0.0.1:8786"):
        pass


@pytest.mark.parametrize(
    ("fate", "message"),
    [
        ("closed", "the connection .* is lost"),
        *further(
            ("empty", r"had no workers for 0\.3 s; start some"),
            ("stopped", r"has not answered for 0\.3 s"),
        ),
    ],
)
def test_a_cluster_that_is_lost_or_empty_ends_in_one_line(fate, message, monkeypatch, caplog):
    distributed = pytest.importorskip("distributed")
    module = "stickslip.ga.execution.cluster"
    monkeypatch.setattr(f"{module}.WITHOUT_WORKERS", 0.3 if fate == "empty" else 60.0)
    monkeypatch.setattr(f"{module}.ANSWER", 0.3 if fate == "stopped" else 60.0)
    monkeypatch.setattr(f"{module}.LOOK", 0.1)
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as empty:
        if fate == "closed":
            threading.Timer(0.3, empty.close).start()
        if fate == "stopped":
            answers = empty.scheduler.handlers
            silent = partial(answers.__setitem__, "ncores", lambda **_: asyncio.sleep(3.0))
            threading.Timer(0.3, silent).start()
        with (
            pytest.raises(ga.WorkersLost, match=message),
            ga.executor(empty.scheduler_address, 2) as executor,
        ):
            history(quadratic, executor)
    (told,) = [r.getMessage() for r in caplog.records if r.name.startswith("stickslip")]
    assert "has no workers; waiting up to" in told


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


def test_a_process_keeps_one_cost_at_a_time():
    costs = (KillsItsWorker(os.getpid(), limit) for limit in (1.0, 2.0))
    first, second = (weakref.ref(Packed.of(cost).unpacked()) for cost in costs)
    assert first() is None
    assert second() is not None


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


def test_a_process_sees_the_environment_and_folder_of_its_pool(tmp_path, monkeypatch):
    for cache in ("one", "two"):
        monkeypatch.setenv("STICKSLIP_CACHE", cache)
        (tmp_path / cache).mkdir()
        monkeypatch.chdir(tmp_path / cache)
        with ga.executor("processes", 1) as one:
            assert one.submit(os.getenv, "STICKSLIP_CACHE").result() == cache
            assert one.submit(os.getcwd).result() == str(tmp_path / cache)


def test_a_process_that_may_have_no_children_says_so(monkeypatch):
    monkeypatch.setitem(multiprocessing.current_process()._config, "daemon", True)
    message = "cannot be started: daemonic .*; use threads"
    with pytest.raises(ga.SettingsError, match=message), ga.executor("processes", 1) as executor:
        history(quadratic, executor)
