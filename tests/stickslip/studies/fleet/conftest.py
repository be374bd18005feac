"""Workers, and tables of drives."""

import sys
from pathlib import Path

import pytest

from stickslip.studies.fleet.table import read_fleet

sys.path.insert(0, str(Path(__file__).parent))  # fleet_jobs; workers import it


@pytest.fixture(scope="module")
def cluster():
    """Return the address of a Dask scheduler with two workers, which are not idle for nothing."""
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


@pytest.fixture(scope="session")
def files():
    """Return what reads all files of a folder, by their places in it."""

    def files(folder):
        found = (path for path in folder.rglob("*") if path.is_file())
        return {path.relative_to(folder): path.read_bytes() for path in found}

    return files
