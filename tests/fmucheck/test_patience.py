"""A slow FMU is tried with fewer things, and is not said to hang."""

import time
from pathlib import Path

import pytest
from lxml import etree

from stickslip import fmucheck
from stickslip.fmucheck.description.model import Description
from stickslip.fmucheck.running import bench as benches
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.parent import TIMEOUT
from tests.corpus.defects.reference import binary_name, members, pack, with_defect


@pytest.mark.parametrize(("elapsed", "tried"), [(0.0, [1, 2, 3]), (1e6, [])])
def test_things_are_tried_while_there_is_time(elapsed, tried):
    description = Description(etree.XML("<a><CoSimulation/></a>"), 2)
    bench = Bench(description, description.interfaces[0], Path(), Path(), [])
    bench.began = time.monotonic() - elapsed
    assert list(bench.while_time([1, 2, 3])) == tried


@pytest.mark.slow
def test_one_instance_per_process_is_respected(tmp_path):
    """An FMU that keeps its state in a global variable is sound if it says so.

    The time is not enough for all rules: what is known by then is reported.
    """
    once = b'canBeInstantiatedOnlyOncePerProcess="true" modelIdentifier='
    sound = members(2)
    description = sound["modelDescription.xml"].replace(b"modelIdentifier=", once)
    binary = {binary_name(2): with_defect("shared-state")}
    path = pack(tmp_path / "a.fmu", sound | {"modelDescription.xml": description} | binary)
    began = time.monotonic()
    report = fmucheck.check(path, total=4.0)
    assert time.monotonic() - began < 12.0
    assert [f for f in report if f.severity > fmucheck.Severity.NOTE] == []
    assert "time for all rules is over" in " ".join(f.message for f in report)


def test_findings_of_one_cause_are_one(tmp_path):
    units = members(2)["modelDescription.xml"].replace(b'unit="', b'unit="other ')
    units = units.replace(b'<Unit name="other ', b'<Unit name="')
    path = pack(tmp_path / "a.fmu", members(2) | {"modelDescription.xml": units})
    found = [f for f in fmucheck.check(path, run=False) if f.rule == "undefined-unit"]
    assert 1 < sum(f.count for f in found) == len(found) + sum(len(f.others) for f in found)
    assert len({f.cause for f in found}) == len(found)


def test_patience_is_shorter_than_the_default_time_limit():
    assert benches.PATIENCE < TIMEOUT
