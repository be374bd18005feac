"""What an FMU tries beyond its folder is denied, and named in one line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from stickslip import cosim
from stickslip.fmi.process import sandbox

pytestmark = pytest.mark.skipif(bool(sandbox.unavailable()), reason=sandbox.unavailable())

OUTSIDE = Path("/var/tmp/stickslip-hostile")  # noqa: S108 (never written)
TRIED = {
    "read_home": f"read {Path.home()}",
    "write_outside": f"write {OUTSIDE}",
    "connect": "open a network connection",
    "execute": "start the program /bin/sh",
    "fork_away": "leave its group of processes",
    "kill_parent": f"send a signal to process {os.getpid()}",
}


def told(hostile, caplog, behaviour, limits):
    """Return the error of a run, or what it warns of."""
    try:
        with hostile(f"DoStep {behaviour}").prepare(step=0.1, stop=0.2, isolation=limits) as s:
            s.run()
    except cosim.SimulationError as error:
        return str(error)
    return "".join(record.getMessage() for record in caplog.records if "sandbox" in record.msg)


@pytest.mark.parametrize("behaviour", TRIED)
def test_what_it_tries_is_denied_and_named(hostile, caplog, behaviour):
    text = told(hostile, caplog, behaviour, cosim.Isolation())
    call = f"plant (DoStep {behaviour} 2.fmu): fmi2DoStep"
    expected = f"{call} tried to {TRIED[behaviour]}, which the sandbox denies"
    assert text.partition(" (--allow")[0].endswith(expected)
    assert not OUTSIDE.exists()


@pytest.mark.parametrize(
    ("behaviour", "word"),
    [("connect", "network"), ("execute", "exec"), ("read_home", f"files={Path.home()}")],
)
def test_what_is_allowed_works(hostile, caplog, behaviour, word):
    assert not told(hostile, caplog, behaviour, cosim.Isolation(allow=(word,)))


def test_shared_memory_counts(hostile, caplog):
    text = told(hostile, caplog, "share", cosim.Isolation(memory=100.0))
    assert "took more than the 100 MB it may" in text


def test_an_unknown_permission_is_refused():
    with pytest.raises(cosim.ExperimentError, match="expected 'network', 'exec' or 'files=DIR'"):
        cosim.Isolation(allow=("everything",))
