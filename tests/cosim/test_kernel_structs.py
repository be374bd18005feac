"""The ctypes structures of the kernel have the sizes and offsets that the compiler gives."""

from __future__ import annotations

import ctypes
import inspect
from itertools import chain
from pathlib import Path

import fmpy
import pytest

from stickslip.cosim import kernel
from stickslip.cosim.kernel import arithmetic, coupling, general_path, marks
from stickslip.fmi import toolchain

MIRRORS = {
    (header, name): structure
    for header, module in {
        "kernel.h": kernel,
        "general_path.h": general_path,
        "coupling.h": coupling,
        "arithmetic.h": arithmetic,
        "mark.h": marks,
    }.items()
    for name, structure in inspect.getmembers(module, inspect.isclass)
    if issubclass(structure, ctypes.Structure) and structure.__module__ == module.__name__
}
ADDED = {"Mark": ["name"]}  # fields behind those of the C structure, which only Python uses


def fields(name, structure):
    return [field for field, *_ in structure._fields_ if field not in ADDED.get(name, [])]


@pytest.fixture(scope="module")
def measured():
    """Return for each structure its size and the offset and size of each field, from C."""
    here = Path(kernel.__file__).parent
    headers = Path(fmpy.__file__).parent / "c-code"
    files = {h.name: h.read_text(encoding="utf-8") for h in here.glob("*.h")}
    files |= {f"system/{h.name}": h.read_text(encoding="utf-8") for h in headers.glob("fmi[23]*.h")}
    units = {}
    for (header, name), structure in MIRRORS.items():
        entries = [
            f"offsetof({name}, {f}), sizeof((({name} *)0)->{f})," for f in fields(name, structure)
        ]
        units[f"{name}.c"] = (
            f'#include <stddef.h>\n#include "kernel.h"\n#include "{header}"\n'
            f"EXPORT extern const size_t layout_{name}[];\n"
            f"const size_t layout_{name}[] = {{sizeof({name}), {' '.join(entries)}}};\n"
        )
    library = ctypes.CDLL(str(toolchain.shared_library("layouts", files | units)))
    return {
        name: list(
            (ctypes.c_size_t * (1 + 2 * len(fields(name, structure)))).in_dll(
                library, f"layout_{name}"
            )
        )
        for (_, name), structure in MIRRORS.items()
    }


@pytest.mark.parametrize("name", [name for _, name in MIRRORS])
def test_a_structure_is_that_of_the_header(measured, name):
    structure = next(s for (_, n), s in MIRRORS.items() if n == name)
    names = fields(name, structure)
    places = [getattr(structure, field) for field in names]
    assert measured[name][1:] == [*chain(*((p.offset, p.size) for p in places))]
    size = getattr(structure, ADDED[name][0]).offset if name in ADDED else ctypes.sizeof(structure)
    assert measured[name][0] == size


def test_every_structure_is_compared():
    assert len(MIRRORS) >= 22
    assert sum(len(s._fields_) for s in MIRRORS.values()) > 200
