"""Plans of runs, compiled steps, structures of the kernel, and the ring against a plain C loop."""

import ctypes
import re
from graphlib import TopologicalSorter
from pathlib import Path

import fmpy
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.coupling import ring
from benchmarks.coupling.ring import Loops
from stickslip.cosim import kernel
from stickslip.cosim.assembly.plan import count_steps
from stickslip.cosim.kernel import MOST_COMPONENTS, structures
from stickslip.cosim.system.loops import stepping_order
from stickslip.fmi import toolchain
from tests.cosim.single import joined


@pytest.mark.parametrize(
    ("start", "stop", "step", "n"),
    [(0, 1, 0.1, 10), (-1, 1, 0.001, 2000), (1.7e9, 1.7e9 + 1, 1e-3, 1000), (0, 1e10, 1, 10**10)],
)
def test_steps_are_counted(start, stop, step, n):
    assert count_steps(start, stop, step) == n


def test_without_feedthrough_the_order_stays():
    assert stepping_order(["c", "a", "b"], []) == ["c", "a", "b"]


@given(st.permutations(range(8)), st.sets(st.tuples(st.integers(0, 7), st.integers(0, 7))))
def test_every_source_comes_first(ranks, pairs):
    names = [f"c{i}" for i in range(8)]
    edges = [(f"c{a}.y", f"c{b}.u") for a, b in pairs if ranks[a] < ranks[b]]
    order = stepping_order(names, edges)
    assert sorted(order) == names
    for source, target in edges:
        assert order.index(source[:2]) < order.index(target[:2])


N = 20_000


def circle(make, n):
    """Gains and integrators of both versions in a circle, and one that nothing feeds."""
    kinds = [("gain" if i % 3 else "integrator", 2 + i % 2) for i in range(n)]
    parts = {f"c{i}": (make(*kind), {"k": 0.5}) for i, kind in enumerate(kinds)}
    return joined(parts, *(f"c{i}.y c{(i + 1) % (n - 1)}.u" for i in range(n - 1)))


SOME = ["c1.y", "c0.*"]


@pytest.mark.parametrize(
    ("n", "coupling", "record"),
    [(MOST_COMPONENTS, "jacobi", SOME), (MOST_COMPONENTS + 1, "gauss_seidel", None)],
)
def test_compiled_steps_give_the_same_bits(make, n, coupling, record):
    spec = {"step": 1e-3, "stop": 1.0, "coupling": coupling, "record": record}
    system = circle(make, n)
    table = system.prepare(**spec).run()
    compiled = system.prepare(**spec, compiled=True).run()
    assert compiled.names == table.names
    np.testing.assert_array_equal(compiled.values, table.values)


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
    assert len(mirrors) >= 19
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


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI 2.0", "FMI 3.0"])
def version(request):
    return request.param


@pytest.fixture(scope="module")
def system(version, tmp_path_factory):
    return ring.system(tmp_path_factory.mktemp("ring"), version)


@pytest.fixture(scope="module")
def loops(version):
    return Loops(version)


def prepare(system, n=N, coupling="jacobi", **options):
    times = {"step": ring.STEP, "stop": n * ring.STEP}
    return system.prepare(**times, coupling=coupling, constant_step=True, **options)


@pytest.mark.parametrize("coupling", ["jacobi", "gauss_seidel"])
def test_every_signal_is_that_of_the_plain_c_loop_to_the_bit(system, version, loops, coupling):
    """By tables; in each version one coupling is compiled as well."""
    expected = (loops.plain if coupling == "jacobi" else loops.in_turn)(N)
    for compiled in {False, (version == 2) == (coupling == "jacobi")}:
        with prepare(system, N, coupling, compiled=compiled) as simulation:
            for _ in range(2):
                result = simulation.run()
                assert result.names == ("controller.u", "mass.v", "mass.x", "friction.f")
                np.testing.assert_array_equal(result.values[1:], expected)
        assert abs(result["mass.v"][-1] - 0.2) < 0.01
        with prepare(system, N, coupling, compiled=compiled, record=["mass.x"]) as simulation:
            np.testing.assert_array_equal(simulation.run()["mass.x"][1:], expected[:, 2])


def test_rings_of_more_fmus_than_a_group_step_all_of_them(tmp_path):
    """All parts of a longer ring move alike, since each sees what the first ring sees."""
    with prepare(ring.system(tmp_path, 2, 30), 1_000) as simulation:
        result = simulation.run()
    with prepare(ring.system(tmp_path, 2), 1_000) as simulation:
        first = simulation.run()
    for i in range(1, 10):
        np.testing.assert_array_equal(result[f"mass{i}.v"], first["mass.v"])
