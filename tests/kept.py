"""What takes long to make is kept in the cache folder for all workers and runs of these sources."""

import hashlib
import shutil
import sys
import time
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cloudpickle
import pytest

from stickslip.fmi.files import atomic_write, lock
from stickslip.fmi.toolchain import cache_directory

ROOT = Path(__file__).parents[1]
MADE_FROM = (
    *("fmi", "models", "cosim", "ga", "stickslip"),
    *(f"tests/stickslip/{room}conftest.py" for room in ("", "identification/")),
    "tests/stickslip/brief.py",
)
PACKAGES = ("numpy", "scipy", "control", "cma", "pandas", "matplotlib", "jinja2")
PLACE = cache_directory() / "tests"
MOST = 4
"""States of the sources, the newest, of which anything is kept."""


@cache
def state() -> str:
    """Return a hash of the sources and of what computes with them."""
    found = hashlib.sha256(repr([sys.version, *map(version, PACKAGES)]).encode())
    for name in MADE_FROM:
        inside = sorted((ROOT / name).rglob("*")) or [ROOT / name]
        for path in inside:
            if path.is_file() and "__pycache__" not in path.parts:
                found.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return found.hexdigest()[:16]


def kept(name: str, make: Callable[[Path], Any]) -> Any:
    """Return what ``make`` returns; it is given a folder that stays, and is called once."""
    own = PLACE / state()
    own.mkdir(parents=True, exist_ok=True)
    with (own / f"{name}.lock").open("w") as file:
        while not lock(file):
            time.sleep(0.1)
        result = own / f"{name}.pickle"
        if not result.exists():
            for old in sorted(PLACE.iterdir(), key=lambda one: one.stat().st_mtime)[:-MOST]:
                shutil.rmtree(old)
            shutil.rmtree(own / name, ignore_errors=True)  # of a run that ended in between
            (own / name).mkdir()
            atomic_write(result, cloudpickle.dumps(make(own / name)))
        return cloudpickle.loads(result.read_bytes())


def further(*cases: Any) -> list[Any]:
    """Return cases of a test as those of the thorough tier."""
    each = [case if isinstance(case, tuple) else (case,) for case in cases]
    return [pytest.param(*case, marks=pytest.mark.thorough) for case in each]
