"""A slow FMU is tried with fewer things, and is not said to hang."""

import time
from pathlib import Path

import pytest

from stickslip.fmucheck.description.model import Description, Interface
from stickslip.fmucheck.running import bench as benches
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.parent import TIMEOUT


@pytest.mark.parametrize(("elapsed", "tried"), [(0.0, [1, 2, 3]), (1e6, [])])
def test_things_are_tried_while_there_is_time(elapsed, tried):
    description = Description(2, {}, [], [], [], [], None, [])
    bench = Bench(description, Interface("CoSimulation", 1, {}), Path(), Path(), [])
    bench.began = time.monotonic() - elapsed
    assert list(bench.while_time([1, 2, 3])) == tried


def test_patience_is_shorter_than_the_default_time_limit():
    assert benches.PATIENCE < TIMEOUT
