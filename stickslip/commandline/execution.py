"""The options of every command that learns: algorithm, workers, checkpoint and seed."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stickslip import ga
from stickslip.commandline import FLAG, add_options, at_least
from stickslip.errors import UsageError
from stickslip.ga.execution.checkpoint import check
from stickslip.work.jobs import Execution, processors, stopped


def add_algorithm_option(
    parser: argparse._ActionsContainer, *aliases: str, default: str = "our genetic algorithm"
) -> None:
    """Declare ``--algorithm``, under other names too; ``default`` says what the default is."""
    parser.add_argument(
        "--algorithm",
        *aliases,
        dest="algorithm",
        choices=ga.ALGORITHMS,
        default="default",
        help=f"default: {default}; paper: the paper's, with linear genes, as published; "
        + "; ".join(f"{name}: {method.title}" for name, method in ga.OTHERS.items()),
    )


def add_worker_options(parser: argparse._ActionsContainer, what: str) -> None:
    """Declare where work is done."""
    workers = f"number of {what} that run in parallel (default: number of processors)"
    add_options(parser, {"--workers N": workers}, type=at_least(1), default=processors())
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--pool",
        dest="where",
        choices=["threads", "processes"],
        default="threads",
        help="kind of workers on this machine",
    )
    dask = "run on Dask: the address of a scheduler (tcp://...), or 'local' to start one here"
    add_options(place, {"--cluster ADDRESS": dask}, dest="where", type=_address)


def _address(text: str) -> str:
    known = {"local", "threads", "processes"}  # argparse gives it the default, too
    if text not in known and "://" not in text:
        raise argparse.ArgumentTypeError(
            f"{text!r}; expected local or the address of a scheduler, such as tcp://10.0.0.1:8786"
        )
    return text


def add_execution_options(parser: argparse._ActionsContainer) -> None:
    """Declare where candidates run, the checkpoint and the seed."""
    add_worker_options(parser, "candidates")
    file = "checkpoint, written after every generation; with this option it is kept at the end"
    add_options(parser, {"--checkpoint FILE": file}, type=Path)
    resume = "continue from the checkpoint of a killed or interrupted run, if there is one"
    add_options(parser, {"--resume": resume}, **FLAG)


def add_seed_option(parser: argparse._ActionsContainer) -> None:
    """Declare ``--seed``."""
    add_options(parser, {"--seed": "random seed of the algorithm"}, type=at_least(0), default=0)


@contextmanager
def execution_of(options: argparse.Namespace, checkpoint: Path | None) -> Iterator[Execution]:
    """Give what the options choose to a block that learns and writes the results.

    At its end the checkpoint is deleted, unless the user named one. Where the block is interrupted,
    the message names what is kept. Raises UsageError when a checkpoint is there and is not to be
    resumed, or StateError when it is to be resumed, but is not a checkpoint. The checkpoint is that
    file unless the user named another one; None writes none.
    """
    file = options.checkpoint or checkpoint
    execution = Execution(options.workers, options.where, file, options.resume)
    for path in _kept(execution, options):  # before anything is done
        if not options.resume:
            raise UsageError(
                f"{path}: an earlier run did not end; continue with --resume, or delete it to "
                "start again"
            )
        check(path)
    try:
        yield execution
    except (KeyboardInterrupt, ga.WorkersLost) as stop:
        kept = _kept(execution, options)
        if not kept or (isinstance(stop, ga.Interrupted) and _seeds(options) == 1):
            raise
        files = ", ".join(map(str, kept))
        raise stopped(stop, f"the state of the search is kept in {files}") from None
    if options.checkpoint is None:
        for path in _kept(execution, options):
            path.unlink(missing_ok=True)


def _kept(execution: Execution, options: argparse.Namespace) -> list[Path]:
    """Return the existing checkpoints; each of several seeds has its own."""
    n = _seeds(options)
    seeds = range(options.seed, options.seed + n) if n > 1 else [0]
    paths = [execution.of_seed(seed, n).checkpoint for seed in seeds]
    return [path for path in paths if path is not None and path.exists()]


def _seeds(options: argparse.Namespace) -> int:
    """Return how many searches the command makes."""
    return getattr(options, "seeds", 1)
