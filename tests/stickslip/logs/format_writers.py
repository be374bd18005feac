"""Logs written by the library of each format: (path, columns by header) -> file."""

import struct

import h5py
import numpy as np
import scipy.io

from stickslip.logs.header import split_unit


def excel(path, columns):
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["measured", 3])
    sheet = book.create_sheet("log")
    sheet.append(["Axis 3", None, 17])
    sheet.append(list(columns))
    for row in zip(*columns.values(), strict=True):
        sheet.append([float(value) for value in row])
    book.save(path)


def tdms(path, columns):
    import nptdms

    time, *rest = columns.values()
    wave = {"wf_increment": (time[-1] - time[0]) / (len(time) - 1), "wf_start_offset": time[0]}
    channels = []
    for header, values in zip(list(columns)[1:], rest, strict=True):
        name, unit = split_unit(header)
        properties = {**wave, "unit_string": unit or ""}
        channels.append(nptdms.ChannelObject("Axis", name, values, properties=properties))
    with nptdms.TdmsWriter(path) as file:
        file.write_segment(channels)


def mdf(path, columns):
    import asammdf

    time, *rest = columns.values()
    signals = []
    for header, values in zip(list(columns)[1:], rest, strict=True):
        name, unit = split_unit(header)
        signals.append(asammdf.Signal(values, time, name=name, unit=unit or ""))
    with asammdf.MDF(version="3.30" if path.suffix == ".mdf" else "4.10") as file:
        file.append(signals)
        file.save(path, overwrite=True)


def hdf5(path, columns):
    with h5py.File(path, "w") as file:
        group = file.create_group("run 1/axis")
        for header, values in columns.items():
            name, unit = split_unit(header)
            group[name] = values
            group[name].attrs["units"] = unit or ""


def hdf5_table(path, columns):
    """One dataset whose rows are structures."""
    kinds = [(name, np.float64) for name in columns]
    table = np.array([*zip(*columns.values(), strict=True)], dtype=kinds)
    with h5py.File(path, "w") as file:
        file["log"] = table


def _signals(columns):
    """Return what Simulink saves as Structure With Time."""
    names = [split_unit(header)[0] for header in list(columns)[1:]]
    fields = [(key, object) for key in ("values", "dimensions", "label")]
    signals = np.zeros((1, len(names)), fields)
    for k, (name, values) in enumerate(zip(names, list(columns.values())[1:], strict=True)):
        signals[0, k] = (values[:, None], 1.0, name)
    return {
        "time": next(iter(columns.values()))[:, None],
        "signals": signals,
        "blockName": "model/To Workspace",
    }


def simulink(path, columns):
    """One block that saves all signals."""
    scipy.io.savemat(path, {"out": _signals(columns), "tout": np.zeros(3)})


def simulink_blocks(path, columns):
    """One block a signal, with names of blocks alone."""
    time, *names = columns
    each = {name: _signals({time: columns[time], name: columns[name]}) for name in names}
    for found in each.values():
        found["signals"][0, 0]["label"] = ""
    scipy.io.savemat(path, {split_unit(name)[0]: found for name, found in each.items()})


def cells(path, columns):
    """A cell array of structures, as dSPACE's with Name, Data and Unit."""
    found = np.empty((1, len(columns)), dtype=object)
    for k, (header, values) in enumerate(columns.items()):
        name, unit = split_unit(header)
        found[0, k] = {"Name": name, "Data": values, "Unit": unit or ""}
    scipy.io.savemat(path, {"log": {"Y": found}})


class Matlab73:
    """A file laid out as MATLAB 7.3 does: arrays transposed, texts as numbers, references."""

    def __init__(self, path) -> None:
        self._file = h5py.File(path, "w", userblock_size=512)
        self._path = path

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()
        with self._path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")

    def put(self, place, value):
        """Write an array, a text or a structure."""
        if isinstance(value, dict):
            group = self._file.require_group(place)
            group.attrs["MATLAB_class"] = np.bytes_("struct")
            for name, inner in value.items():
                self.put(f"{place}/{name}", inner)
        elif isinstance(value, str):
            self._file[place] = np.array([[ord(c)] for c in value], dtype=np.uint16)
            self._file[place].attrs["MATLAB_class"] = np.bytes_("char")
        else:
            self._file[place] = np.atleast_2d(np.asarray(value, dtype=np.float64)).T
            self._file[place].attrs["MATLAB_class"] = np.bytes_("double")

    def put_array(self, place, structures):
        """Write an array of structures: a group of arrays of references."""
        group = self._file.require_group(place)
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name in structures[0]:
            self._file[f"{place}/{name}"] = self._references([one[name] for one in structures])

    def put_object(self, place, cls):
        """Write an object: numbers that only MATLAB can interpret."""
        self._file[place] = np.arange(6, dtype=np.uint32)[:, None]
        self._file[place].attrs["MATLAB_class"] = np.bytes_(cls)
        self._file[place].attrs["MATLAB_object_decode"] = 3

    def _references(self, values):
        first = len(self._file.require_group("#refs#"))  # none nested
        for k, value in enumerate(values):
            self.put(f"#refs#/{first + k}", value)
        references = [self._file[f"#refs#/{first + k}"].ref for k in range(len(values))]
        return np.array(references, dtype=h5py.ref_dtype)[:, None]


def matlab73(path, columns):
    with Matlab73(path) as file:
        file.put("log", {split_unit(name)[0]: v[:, None] for name, v in columns.items()})
        file.put("gtau", 3.5)


def matlab73_simulink(path, columns):
    found = _signals(columns)
    signals = [dict(zip(one.dtype.names, one, strict=True)) for one in found["signals"][0]]
    with Matlab73(path) as file:
        file.put("out", {"time": found["time"], "blockName": found["blockName"]})
        file.put_array("out/signals", signals)


def matlab_object(path, name, cls):
    """Write an object as MATLAB 7 does: an element that names its class, and numbers."""

    def element(kind, content):
        return struct.pack("<II", kind, len(content)) + content.ljust(
            -(-len(content) // 8) * 8, b"\0"
        )

    numbers = element(6, struct.pack("<II", 13, 0)) + element(5, struct.pack("<ii", 2, 1))
    numbers = element(14, numbers + element(1, b"") + element(6, struct.pack("<II", 1, 2)))
    texts = b"".join(element(1, text.encode()) for text in (name, "MCOS", cls))
    opaque = element(14, element(6, struct.pack("<II", 17, 0)) + texts + numbers)
    path.write_bytes(b"MATLAB 5.0 MAT-file, Platform: PCWIN64".ljust(124) + b"\0\1IM" + opaque)
