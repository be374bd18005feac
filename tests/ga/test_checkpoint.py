"""Runs that survive: whole checkpoints, and resumed runs that are the uninterrupted ones."""

import json
import os
import signal
import sys

import pytest
from problems import GENES, quadratic, sometimes_fails

from stickslip import ga

PROBLEM = ga.Problem(GENES, ga.AtLeast("b", "a"))
LIMITS = ga.Limits(evaluations=200)


def new(algorithm="default", limits=LIMITS, seed=4):
    return ga.optimiser(algorithm, PROBLEM, limits, seed)


class Stopped(Exception):
    pass


def stop_at(generation):
    def stop(optimiser):
        if optimiser.generation == generation:
            raise Stopped

    return stop


@pytest.mark.parametrize("algorithm", ga.ALGORITHMS)
def test_a_resumed_run_is_the_uninterrupted_one(algorithm, tmp_path):
    whole, path = new(algorithm), tmp_path / "run.json"
    found = ga.learn(whole, sometimes_fails, checkpoint=tmp_path / "whole.json")
    for generation in (1, 2, 9):
        with pytest.raises(Stopped):
            ga.learn(
                new(algorithm), sometimes_fails, None, stop_at(generation),
                checkpoint=path, resume=True,
            )  # fmt: skip
    resumed = new(algorithm)
    again = ga.learn(resumed, sometimes_fails, checkpoint=path, resume=True)
    assert resumed.history.to_csv() == whole.history.to_csv()
    assert resumed.convergence().to_csv() == whole.convergence().to_csv()
    assert path.read_bytes() == (tmp_path / "whole.json").read_bytes()
    assert (again.parameters, again.stopped) == (found.parameters, found.stopped)


@pytest.mark.parametrize("keep", [True, False])
def test_ctrl_c_says_what_is_kept_and_how_to_go_on(keep, tmp_path):
    path = tmp_path / "run.json" if keep else None

    def interrupt(optimiser):
        if optimiser.generation == 3:
            raise KeyboardInterrupt

    kept = "run.json.*resume=True" if keep else "nothing"
    expected = rf"3 generations \(26 evaluations\).*{kept}"
    with pytest.raises(ga.Interrupted, match=expected):
        ga.learn(new(), quadratic, None, interrupt, checkpoint=path)
    if path is not None:
        resumed = new()
        resumed.replay(json.loads(path.read_text()))
        assert resumed.generation == 3


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="has another Ctrl-C")
def test_ctrl_c_ends_processes_quietly(capfd):
    """A terminal sends it to the workers as well."""
    with ga.executor("processes", 2) as executor:

        def interrupt(optimiser):
            if optimiser.generation == 3:
                for process in (*executor._pool._processes, os.getpid()):
                    os.kill(process, signal.SIGINT)

        with pytest.raises(ga.Interrupted):
            ga.learn(new(), quadratic, executor, interrupt)
    assert "Traceback" not in capfd.readouterr().err


@pytest.fixture
def kept(tmp_path):
    """Return the checkpoint of a run about drive 1."""
    path = tmp_path / "run.json"
    ga.learn(new(), quadratic, checkpoint=path, about="drive 1")
    return path


def test_an_earlier_run_is_not_overwritten(kept):
    text = kept.read_text()
    with pytest.raises(ga.StateError, match=r"run\.json: holds an earlier learning run"):
        ga.learn(new(), quadratic, checkpoint=kept)
    assert kept.read_text() == text


@pytest.mark.parametrize(
    ("resumed", "drive", "message"),
    [
        (lambda: new("cma"), 1, "other optimiser"),
        (lambda: new("paper"), 1, "other settings"),
        (lambda: new(seed=5), 1, "other seed"),
        (lambda: ga.optimiser("default", ga.Problem(GENES), LIMITS, 4), 1, "other repair"),
        (lambda: ga.optimiser("default", ga.Problem(GENES[:2], PROBLEM.repair)), 1, "other genes"),
        (new, 2, "about 'drive 1', expected 'drive 2'"),
    ],
)
def test_a_checkpoint_of_another_run_is_refused(resumed, drive, message, kept):
    with pytest.raises(ga.StateError, match=rf"run\.json: .*{message}"):
        ga.learn(resumed(), quadratic, checkpoint=kept, resume=True, about=f"drive {drive}")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        *((text, "this is no checkpoint") for text in ("", '{"format": 1}')),
        ('{"format": 2, "format": 2}', "is there twice"),
    ],
)
def test_a_checkpoint_is_checked_before_it_is_resumed(text, said, tmp_path):
    path = tmp_path / "run.json"
    path.write_text(text)
    with pytest.raises(ga.StateError, match=rf"run\.json: .*{said}"):
        ga.learn(new(), quadratic, checkpoint=path, resume=True)


@pytest.mark.parametrize("cost", [-1.0, "1", [], float("-inf")])
def test_a_cost_that_is_none_is_damage(cost):
    optimiser = new()
    optimiser.tell([quadratic(row) for row in optimiser.ask()])
    kept = optimiser.state()
    kept["evaluations"][3][2] = cost
    with pytest.raises(ga.StateError, match="damaged"):
        new().replay(kept)


def test_what_cannot_be_repeated_is_refused():
    state = new()
    state.tell([quadratic(row) for row in state.ask()])
    kept = state.state()
    kept["evaluations"][3][1][0] *= 1 + 1e-9
    with pytest.raises(ga.StateError, match="generation 1 of the checkpoint cannot be repeated"):
        new().replay(kept)
    with pytest.raises(ga.CallOrderError, match="replay needs a new optimiser"):
        state.replay(kept)
