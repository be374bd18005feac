"""Systems of one hostile FMU, and what a process has left behind."""

from collections.abc import Callable

import pytest

from stickslip import cosim
from tests.corpus.hostile import fmus
from tests.cosim.single import one

Hostile = Callable[..., cosim.System]


@pytest.fixture(scope="session")
def hostile(tmp_path_factory) -> Hostile:
    """Make a system: ``hostile("DoStep segv 3")``."""
    folder = tmp_path_factory.mktemp("hostile")

    def make(behaviour: str = "", version: int = 2) -> cosim.System:
        path = folder / f"{behaviour or 'clean'} {version}.fmu"
        if not path.exists():
            fmus.write(path, behaviour, version=version)
        return one(path, u="u", name="plant")

    return make
