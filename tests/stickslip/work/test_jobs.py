"""Jobs on workers."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import pytest

from stickslip import ga
from stickslip.work.jobs import Outcome, run_jobs


class Cluster(ThreadPoolExecutor):
    """Counts the jobs that wait or run at the same time."""

    parts = 2
    most = 0

    def submit(self, fn, /, *args):
        future = super().submit(fn, *args)
        self.most = max(self.most, self._work_queue.qsize())
        return future


def echoed(item: int, seed: int) -> Outcome:
    return Outcome(learned=str(item + seed))


@pytest.fixture
def cluster(monkeypatch):
    with Cluster(max_workers=2) as cluster:
        monkeypatch.setattr(ga, "executor", lambda *_: nullcontext(cluster))
        yield cluster


def test_a_cluster_gets_a_few_jobs_at_a_time_so_that_an_interruption_leaves_few(cluster):
    done = {}
    run_jobs(echoed, range(100), 1, "tcp://somewhere", 1, done.__setitem__)
    assert {item: outcome.learned for item, outcome in done.items()} == {
        item: str(item + 1) for item in range(100)
    }
    assert cluster.most <= 2 * cluster.parts


@pytest.mark.usefixtures("cluster")
def test_an_interruption_leaves_no_more_than_what_runs():
    begun = []

    def job(item: int, _: int) -> Outcome:
        begun.append(item)
        return Outcome()

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_jobs(job, range(1000), 0, "tcp://somewhere", 1, interrupt)
    assert len(begun) <= 2 * Cluster.parts
