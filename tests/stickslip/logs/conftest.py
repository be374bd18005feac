"""Logs with known content."""

import pandas as pd
import pytest
import scipy.io

from stickslip.cli import main
from stickslip.logs import Recording, read_recording
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Datasheet
from tests.stickslip.logs.rigid_drive import rigid_drive


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


@pytest.fixture
def read_log(tmp_path):
    """Return a function that writes a log, text or bytes, and reads it."""

    def read(content, given=None, *, name="log.csv", strict=True):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_recording(path, given, strict=strict)

    return read


@pytest.fixture
def check_log(tmp_path, capsys):
    """Return a function that checks a log: status, errors, standard output, standard error."""

    def run(table, *options, file="log.csv"):
        path = tmp_path / file
        if path.suffix == ".mat":
            scipy.io.savemat(path, {name: table[name].to_numpy() for name in table})
        elif path.suffix == ".parquet":
            table.to_parquet(path)
        else:
            table.to_csv(path, index=False)
        status = main(["learn", "--log", str(path), "--check", *options])
        out, err = capsys.readouterr()
        return status, [line for line in out.splitlines() if line.startswith("error: ")], out, err

    return run


@pytest.fixture(scope="session")
def drive_log(fmus, loop):
    """Return a function that records the paper's drive under a velocity command (n,)."""
    rig = FmuRig(str(fmus), Datasheet(), LOOP.T_s)

    def record(v) -> Recording:
        log = rig.follow(v, loop)
        return Recording(log.t, log.x_enc, log.F_m, velocity_command=v, encoder_step=4e-7)

    return record
