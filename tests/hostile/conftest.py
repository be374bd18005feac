"""Compiles once, before tests are given caches of their own."""

import pytest

from benchmarks.hostile import fmus
from cosim import kernel


@pytest.fixture(scope="session", autouse=True)
def compiled():
    kernel.built()
    kernel.built(marked=True)
    fmus.library()
