"""Logs with known content."""

import sys
from pathlib import Path

import pandas as pd
import pytest

sys.path.insert(0, str(Path(__file__).parent))  # rigid_drive

from rigid_drive import rigid_drive

DATA = Path(__file__).resolve().parents[4] / "shared" / "data"


def shared(name: str) -> Path:
    """Return a file of measured data, or skip the test and say why."""
    path = DATA / name
    if not path.exists():
        pytest.skip(f"{path} is not here")
    return path


@pytest.fixture
def emps() -> Path:
    return shared("emps/DATA_EMPS.mat")


@pytest.fixture
def tribometer() -> Path:
    return shared("tribometer/test_data_2.txt")


@pytest.fixture
def table() -> pd.DataFrame:
    """A log in SI units: time, position, force, velocity_command; 0.4 um steps."""
    drive = rigid_drive(n=600, step=4e-7)
    return pd.DataFrame(
        {
            "time": drive.t,
            "position": drive.position,
            "force": drive.force,
            "velocity_command": drive.velocity,
        }
    )
