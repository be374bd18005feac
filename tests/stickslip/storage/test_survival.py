"""Whenever a process is killed or a disk is full, the old set or the new one is there, whole."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def outcomes():
    """What was found; a set that is lost makes the process fail."""
    if sys.platform == "win32":
        pytest.skip("forks")
    command = [sys.executable, "-m", "campaigns.survival", "--times", "8"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_killed_before_any_operation_a_whole_set_is_left(outcomes):
    """Only while the files change places does it take ``stickslip verify`` to see a whole set."""
    killed = outcomes["killed at each operation"]
    assert killed["at once"] > 40
    assert 0 < killed["recovered"] <= 6  # one for each file of the new set, and the one that leaves


def test_killed_at_random_moments_a_whole_set_is_left(outcomes):
    assert sum(outcomes["killed at random"].values()) == 8


@pytest.mark.parametrize("how", ["full once", "full for good"])
def test_without_room_for_any_operation_a_whole_set_is_left(outcomes, how):
    assert outcomes[how]["at once"] > 35
    assert outcomes[how]["recovered"] <= 6


def test_a_folder_that_vanishes_leaves_a_whole_set_or_a_complaint(outcomes):
    assert sum(outcomes["removed"].values()) == 8
