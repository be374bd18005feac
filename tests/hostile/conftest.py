"""Compiles once, before tests are given caches of their own."""

import pytest

from stickslip.cosim import kernel
from stickslip.cosim.fmu.library import fmi1_wrapper
from tests.corpus.defects import reference
from tests.corpus.hostile import faults, fmus


@pytest.fixture(scope="session", autouse=True)
def compiled():
    kernel.load()
    fmi1_wrapper()
    kernel.built(marked=True)
    faults.library()
    fmus.library()
    reference.library()
