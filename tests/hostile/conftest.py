"""Compiles once, before tests are given caches of their own."""

import pytest

from benchmarks.defects import reference
from cosim import kernel


@pytest.fixture(scope="session", autouse=True)
def compiled():
    kernel.load()
    kernel.load(None)  # as the kernel asks for it
    for version in (2, 3):
        reference.library(version)
