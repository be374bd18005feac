"""Short logs of a drive, and workers."""

import sys
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from cosim.control import design_velocity_loop
from stickslip.fleet import read_fleet
from stickslip.plan import LINEAR, plan
from stickslip.record_mode import COMMISSIONING
from stickslip.rig import rig_of

sys.path.insert(0, str(Path(__file__).parent))  # fleet_jobs; workers import it


@pytest.fixture(scope="session")
def log(tmp_path_factory):
    """Return a log of 2 s of a drive with m = 8 kg and F_c = 4 N, every other sample."""
    path = tmp_path_factory.mktemp("log") / "log.csv"
    with rig_of({"m": 8.0, "F_c": 4.0}) as rig:
        loop = design_velocity_loop(rig.datasheet.axis(5.5, 0.0), COMMISSIONING)
        v_cmd = plan(replace(LINEAR, duration=2.0))["velocity_command"].to_numpy()
        log = rig.follow(v_cmd, loop)
    table = {"time": log.t, "position": log.x_enc, "force": log.F_m}
    pd.DataFrame(table)[::2].to_csv(path, index=False)
    return path


@pytest.fixture(scope="session")
def cluster():
    """Return the address of a Dask scheduler with two workers."""
    dask = pytest.importorskip("dask")
    distributed = pytest.importorskip("distributed")
    quiet = {
        "distributed.scheduler.allowed-failures": 0,
        "distributed.worker.daemon": True,
        "distributed.logging.distributed": "critical",
    }
    with (
        dask.config.set(quiet),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs="CRITICAL"
        ) as local,
    ):
        yield local.scheduler_address


@pytest.fixture
def drives(tmp_path):
    """Return a function that reads a table of drives from names; they have no log."""

    def make(*names):
        table = tmp_path / "table.csv"
        table.write_text("name,log\n" + "".join(f"{name},none.csv\n" for name in names))
        return read_fleet(table)

    return make
