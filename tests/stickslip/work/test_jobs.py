"""Jobs on workers, and the options on where learning runs and what is kept."""

import argparse
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import pytest

from stickslip import ga
from stickslip.cli import main
from stickslip.commandline.execution import (
    add_algorithm_option,
    add_execution_options,
    execution_of,
)
from stickslip.errors import UsageError
from stickslip.ga.execution import checkpoint
from stickslip.work.jobs import Execution, Outcome, processors, run_jobs


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


def chosen(*arguments):
    parser = argparse.ArgumentParser()
    parser.set_defaults(seed=0)
    add_algorithm_option(parser, "--preset")
    add_execution_options(parser)
    return parser.parse_args(arguments)


def test_options_become_an_execution(tmp_path):
    path = tmp_path / "learning.checkpoint.json"

    def execution(*arguments):
        with execution_of(chosen(*arguments), path) as found:
            return found

    assert execution() == Execution(processors(), "threads", path)
    there = execution("--workers", "3", "--pool", "processes", "--resume")
    assert there == Execution(3, "processes", path, resume=True)
    assert execution("--cluster", "tcp://h:1").where == "tcp://h:1"
    assert execution("--checkpoint", "mine.json").checkpoint.name == "mine.json"
    assert chosen("--preset", "paper").algorithm == chosen("--algorithm", "paper").algorithm


def test_an_unfinished_run_is_not_overwritten_unasked(tmp_path):
    path = tmp_path / "learning.checkpoint.json"
    algorithm = ga.GeneticAlgorithm([ga.Gene("a", 0.1, 2.0, 1.0)])
    checkpoint.write(path, algorithm.state(), "")
    with (
        pytest.raises(UsageError, match=r"an earlier run did not end; continue with --resume"),
        execution_of(chosen(), path),
    ):
        pass
    with execution_of(chosen("--resume"), path) as execution:
        assert execution.resume


def test_only_a_checkpoint_that_the_user_named_is_kept(tmp_path):
    for named, kept in (((), False), (("--checkpoint", str(tmp_path / "mine.json")), True)):
        options = chosen(*named, "--resume")
        with execution_of(options, tmp_path / "ours.json") as execution:
            execution.checkpoint.touch()
        assert execution.checkpoint.exists() == kept


@pytest.mark.parametrize(
    ("seeds", "kept"), [(5, "learning.checkpoint.seed0.json"), (1, "learning.checkpoint.json")]
)
def test_ctrl_c_prints_one_line_on_how_to_continue(monkeypatch, tmp_path, capsys, seeds, kept):
    """In a search, before it and after it."""

    def searching(*_):
        raise ga.Interrupted(tmp_path / "learning.checkpoint.json", 7, 58)

    def before(*_):
        raise KeyboardInterrupt

    def after(*given):
        given[-1].of_seed(0, seeds).checkpoint.touch()
        raise KeyboardInterrupt

    said = []
    for interrupted in (searching, before, after):
        monkeypatch.setattr("stickslip.papers.lugre.reproduction.reproduce", interrupted)
        assert main(["reproduce", "--out", str(tmp_path), "--seeds", str(seeds)]) == 130
        said.append(capsys.readouterr().err)
    assert said[0].startswith("stickslip: interrupted after 7 generations (58 evaluations); ")
    assert "--resume" in said[0]
    state = f"the state of the search is kept in {tmp_path / kept}; continue with --resume"
    assert said[1:] == ["stickslip: interrupted\n", f"stickslip: interrupted; {state}\n"]
    assert said[0].count("\n") == 1
