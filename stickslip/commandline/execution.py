"""The options of every command that learns: algorithm, workers and seed."""

import argparse

from stickslip import ga
from stickslip.commandline import add_options, at_least
from stickslip.work.jobs import processors


def add_algorithm_option(
    parser: argparse._ActionsContainer, default: str = "our genetic algorithm"
) -> None:
    """Declare ``--algorithm``; ``default`` says what the default is."""
    parser.add_argument(
        "--algorithm",
        choices=ga.ALGORITHMS,
        default="default",
        help=f"default: {default}; paper: the paper's, with linear genes, as published; "
        + "; ".join(f"{name}: {method.title}" for name, method in ga.OTHERS.items()),
    )


def add_workers_option(parser: argparse._ActionsContainer, what: str) -> None:
    """Declare ``--workers``."""
    workers = f"number of {what} that run in parallel (default: number of processors)"
    add_options(parser, {"--workers N": workers}, type=at_least(1), default=processors())


def add_worker_options(parser: argparse._ActionsContainer, what: str) -> None:
    """Declare where jobs run."""
    add_workers_option(parser, what)
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--pool",
        dest="where",
        choices=["threads", "processes"],
        default="threads",
        help="kind of workers on this machine",
    )
    dask = "run on Dask: the address of a scheduler, such as tcp://10.0.0.1:8786"
    add_options(place, {"--cluster ADDRESS": dask}, dest="where", type=_address)


def _address(text: str) -> str:
    if text not in {"threads", "processes"} and "://" not in text:  # it gets the default, too
        what = "expected the address of a scheduler, such as tcp://10.0.0.1:8786"
        raise argparse.ArgumentTypeError(f"{text!r}; {what}")
    return text


def add_seed_option(parser: argparse._ActionsContainer) -> None:
    """Declare ``--seed``."""
    add_options(parser, {"--seed": "random seed of the algorithm"}, type=at_least(0), default=0)
