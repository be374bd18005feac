"""The ctypes structures of the kernel have the sizes and offsets that the compiler gives."""

from __future__ import annotations

import ctypes
import re
from graphlib import TopologicalSorter
from pathlib import Path

import fmpy

from stickslip.cosim import kernel
from stickslip.cosim.kernel import structures
from stickslip.fmi import toolchain

HEADERS = ["kernel.h", "general_path.h", "coupling.h", "arithmetic.h", "mark.h"]
OWN = {"Fmi2", "Fmi3", "Polynomial"}  # of C alone
ADDED = {"Mark": ["name"]}  # fields behind those of the C structure, which only Python uses


def test_structures_have_the_layout_of_the_headers():
    here, standard = Path(kernel.__file__).parent, Path(fmpy.__file__).parent / "c-code"
    files = {h.name: h.read_text(encoding="utf-8") for h in here.glob("*.h")}
    files |= {f"system/{h.name}": h.read_text() for h in standard.glob("fmi[23]*.h")}
    classes = {name: getattr(structures, name) for name in structures._BODIES if name not in OWN}
    mirrors = {
        name: {f: getattr(c, f) for f, *_ in c._fields_ if f not in ADDED.get(name, [])}
        for name, c in classes.items()
    }
    places = [(name, field) for name, fields in mirrors.items() for field in fields]
    assert len(mirrors) >= 22
    assert len(places) > 200
    entries = [f"sizeof({name})," for name in mirrors]
    entries += [f"offsetof({n}, {f}), sizeof((({n} *)0)->{f})," for n, f in places]
    includes = "".join(f'#include "{header}"\n' for header in HEADERS)
    files["layouts.c"] = (
        f"#include <stddef.h>\n{includes}EXPORT extern const size_t layouts[];\n"
        f"const size_t layouts[] = {{{' '.join(entries)}}};\n"
    )
    library = ctypes.CDLL(str(toolchain.shared_library("layouts", files)))
    found = iter((ctypes.c_size_t * (len(mirrors) + 2 * len(places))).in_dll(library, "layouts"))
    sizes = {name: next(found) for name in mirrors}
    for name, size in sizes.items():
        added = ADDED.get(name)
        c = classes[name]
        assert size == (getattr(c, added[0]).offset if added else ctypes.sizeof(c)), name
    for name, field in places:
        mirror = mirrors[name][field]
        assert (next(found), next(found)) == (mirror.offset, mirror.size), f"{name}.{field}"


def test_no_files_of_the_kernel_call_each_other_in_a_circle():
    """Each may call what lies below it, as the headers say."""
    files = {path.stem: path.read_text() for path in Path(kernel.__file__).parent.glob("*.c")}
    defined = {
        name: stem
        for stem, text in files.items()
        for name in re.findall(r"^(?!static|typedef)\w[\w *]*?\b(\w+)\([^;]*?\) \{", text, re.M)
    }
    calls = {
        stem: {defined[name] for name in re.findall(r"\b\w+(?=\()", text) if name in defined}
        for stem, text in files.items()
    }
    order = [*TopologicalSorter({stem: calls[stem] - {stem} for stem in calls}).static_order()]
    general = ["general_calls", "values", "events", "exchange", "saving", "general_path"]
    assert [stem for stem in order if stem in general] == general
    assert order.index("coupled") < order.index("adaptive") < order.index("run")
