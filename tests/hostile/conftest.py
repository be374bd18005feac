"""Compiles once, before tests are given caches of their own."""

import pytest

from benchmarks.defects import reference
from benchmarks.hostile import fmus
from stickslip.cosim import kernel


@pytest.fixture(scope="session", autouse=True)
def compiled():
    kernel.built()
    kernel.built(marked=True)
    fmus.library()
    for version in (2, 3):
        reference.library(version)
