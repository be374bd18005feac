"""Logs in the formats of other tools: each file is made by that format's own library."""

import gzip
import importlib.util
import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from stickslip.cli import main
from stickslip.errors import RecordingError
from stickslip.fmi.messages import installing
from stickslip.logs import read_recording, reader_process
from stickslip.logs.formats import read_table
from tests.stickslip.logs import format_writers as writers

FILES = {
    "excel": ("log.xlsx", writers.excel),
    "tdms": ("log.tdms", writers.tdms),
    "mdf": ("log.mf4", writers.mdf),
    "mdf 3": ("log.mdf", writers.mdf),
    "hdf5": ("log.h5", writers.hdf5),
    "hdf5 table": ("log.hdf5", writers.hdf5_table),
    "simulink": ("log.mat", writers.simulink),
    "simulink blocks": ("log.mat", writers.simulink_blocks),
    "cells": ("log.mat", writers.cells),
    "matlab 7.3": ("log.mat", writers.matlab73),
    "simulink in 7.3": ("log.mat", writers.matlab73_simulink),
}
WITHOUT_UNITS = ("simulink", "simulink blocks", "matlab 7.3", "simulink in 7.3")
EXTRAS = {
    "log.xlsx": ("openpyxl", "excel"),
    "log.tdms": ("nptdms", "tdms"),
    "log.mf4": ("asammdf", "mdf"),
    "log.h5": ("h5py", "hdf5"),
    "log.parquet": ("pyarrow", "parquet"),
}


def columns(table, *, units: bool = True):
    """Return time, position, force and command, in mm where units are stated."""
    scale, mm = (1e3, " [mm]") if units else (1.0, "")
    return {
        "time [s]" if units else "time": table["time"].to_numpy(),
        f"Actual position{mm}": table["position"].to_numpy() * scale,
        "Motor force [N]" if units else "Motor force": table["force"].to_numpy(),
        f"v_cmd{mm[:-1]}/s]" if units else "v_cmd": table["velocity_command"].to_numpy() * scale,
    }


def test_a_compressed_log_is_the_same_log_and_no_more_is_decompressed_than_is_read_as_text(
    table, tmp_path, monkeypatch
):
    text = table.to_csv(index=False).encode()
    (tmp_path / "log.csv").write_bytes(text)
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(text))
    plain, same = (read_table(tmp_path / name) for name in ("log.csv", "log.csv.gz"))
    for name, column in plain.numbers.items():
        np.testing.assert_array_equal(same.numbers[name], column)
    monkeypatch.setattr("stickslip.logs.formats.MOST_BYTES", len(text) - 1)
    with pytest.raises(RecordingError, match="when decompressed; log fewer"):
        read_table(packed)
    packed.write_bytes(gzip.compress(text)[:-9])
    with pytest.raises(RecordingError, match="not a gzip file, or damaged"):
        read_table(packed)


@pytest.mark.parametrize("kind", FILES)
def test_what_a_library_writes_reads_back_equal(kind, table, tmp_path):
    name, write = FILES[kind]
    write(tmp_path / name, columns(table, units=kind not in WITHOUT_UNITS))
    reading = read_recording(tmp_path / name)
    np.testing.assert_allclose(reading.recording.t, table["time"], rtol=1e-9, atol=1e-9)
    for name in ("position", "force", "velocity_command"):
        np.testing.assert_allclose(getattr(reading.recording, name), table[name], atol=1e-9)


@pytest.mark.parametrize("name", EXTRAS)
def test_a_missing_library_is_named_with_its_extra(name, table, tmp_path, monkeypatch, capsys):
    library, extra = EXTRAS[name]
    path = tmp_path / name
    if extra == "parquet":
        table.to_parquet(path)
    else:
        next(write for file, write in FILES.values() if file == name)(path, columns(table))
    monkeypatch.setitem(sys.modules, library, None)
    assert main(["learn", "--log", str(path), "--check"]) == 1
    error = capsys.readouterr().err
    assert f"needs {library}; {installing(extra)}" in error
    assert error.count("\n") == 1


def test_the_extras_are_declared():
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text("utf-8"))
    optional = project["project"]["optional-dependencies"]
    for library, extra in EXTRAS.values():
        assert optional[extra][0].lower().startswith(library)
        assert extra in optional["logs"][0]
        assert importlib.util.find_spec(library), "the tests need it"


def test_the_content_decides_before_the_name_does(table, tmp_path):
    writers.excel(tmp_path / "log.xlsx", columns(table))
    (tmp_path / "log.xlsx").rename(tmp_path / "log.csv")
    reading = read_recording(tmp_path / "log.csv")
    assert any("is Excel, although its name ends in .csv" in str(f) for f in reading.findings)


def test_signals_of_other_times_are_interpolated(tmp_path):
    """The times are those of the position, not the finest."""
    fast, slow = np.arange(4000) * 5e-4, np.arange(1000) * 2e-3
    with writers.Matlab73(tmp_path / "log.mat") as file:
        for name, t, values in (
            ("noise", np.arange(9000) * 2e-4, np.zeros(9000)),
            ("position", slow, np.sin(slow)),
            ("force", fast, 3.0 * fast),
        ):
            file.put(name, {"time": t, "data": values, "unit": ""})
    table = read_table(tmp_path / "log.mat")
    np.testing.assert_array_equal(table.numbers["time"], slow)
    np.testing.assert_array_equal(table.numbers["position"], np.sin(slow))
    np.testing.assert_allclose(table.numbers["force"], 3.0 * slow)
    assert any("interpolated to those of position: " in str(f) for f in table.findings)


@pytest.mark.parametrize("shape", ["(n, 2)", "(2, n)", "(1, 2, n)"])
def test_matrices_of_signals(shape, tmp_path):
    n = 50
    values = np.arange(2 * n, dtype=float).reshape(n, 2)
    found = {"(n, 2)": values, "(2, n)": values.T, "(1, 2, n)": values.T[None]}[shape]
    signals = {"values": found, "dimensions": 2.0, "label": "log"}
    content = {"out": {"time": np.arange(n) * 1e-3, "signals": signals}}
    scipy.io.savemat(tmp_path / "log.mat", content)
    table = read_table(tmp_path / "log.mat")
    assert table.names == ("time", "log(1)", "log(2)")
    np.testing.assert_array_equal(table.numbers["log(2)"], values[:, 1])


@pytest.mark.parametrize("version", [7, 7.3])
def test_objects_of_matlab_are_named(version, tmp_path):
    path, cls = tmp_path / "log.mat", "Simulink.SimulationData.Dataset"
    if version == 7:
        writers.matlab_object(path, "out", cls)
    else:
        with writers.Matlab73(path) as file:
            file.put_object("out", cls)
    with pytest.raises(RecordingError, match=rf"out: .* object .{cls}.* structure with time"):
        read_recording(path)


def test_a_group_is_a_signal_and_soft_links_and_references_to_nothing_are_left_out(tmp_path):
    t = np.arange(50) * 1e-3
    with h5py.File(tmp_path / "log.h5", "w") as file:
        for name, unit in (("position", "mm"), ("force", "N")):
            group = file.create_group(name)
            group["time"], group["value"] = t * 1e3, t
            group["time"].attrs["unit"], group.attrs["Unit"] = "ms", unit
        file["position/circle"] = h5py.SoftLink("/")
    table = read_table(tmp_path / "log.h5")
    assert table.units == {"force": "N", "position": "mm", "time": "s"}
    np.testing.assert_allclose(table.numbers["time"], t)
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["x"] = np.array([h5py.Reference()], dtype=h5py.ref_dtype)
        file["text"] = "hello"
    with pytest.raises(RecordingError, match="no vectors of numbers"):
        read_recording(tmp_path / "log.h5")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("reader", "message"),
    [
        ("import os; os.abort()", "its reader ended with -6"),
        ("import time; time.sleep(60)", "not read within 1 s"),
        ("print('no archive')", "its reader ended with 0"),
    ],
)
def test_a_reader_that_crashes_or_hangs(reader, message, tmp_path, monkeypatch):
    (tmp_path / "reader.py").write_text(reader)
    monkeypatch.setattr(reader_process, "__file__", str(tmp_path / "reader.py"))
    monkeypatch.setattr("stickslip.logs.signals.TIMEOUT", 1.0)
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {"t": np.arange(50) * 1e-3, "x": np.arange(50.0)})
    with pytest.raises(RecordingError, match=message):
        read_recording(path)
