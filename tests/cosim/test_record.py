"""What a record keeps is what NumPy takes from the full one, to the bit; and runs that fail."""

import csv
import tracemalloc

import numpy as np
import pytest
from pyarrow import parquet

from stickslip import cosim
from stickslip.cosim import Record
from stickslip.cosim.run.result import writing
from tests.cosim.single import joined, one

N = 1000  # several blocks of the kernel, and neither 7 nor 300 divides it
GIVE_NAN, TERMINATE, RETURN_EARLY = 10, 11, 12
COUPLINGS = ["gauss_seidel", "jacobi", cosim.Coupling(degree=1)]


@pytest.fixture
def system(make):
    """x'' = u - x in both versions, with a gain whose input is exposed beside it."""
    parts = {
        "spring": (make("gain", 2), {"k": -1.0}),
        "speed": (make("integrator", 3), {"k": 0.0}),
        "position": (make("integrator", 2), {"k": 1.0}),
        "force": (make("gain", 3), {"k": 0.5}),
    }
    wires = "position.y spring.u", "spring.y speed.u", "speed.y position.u"
    return joined(parts, *wires, u="force.u")


def prepare(system, record=None, **options):
    return system.prepare(step=0.01, stop=N * 0.01, record=record, **options)


INPUT = {"u": lambda t: np.sin(3 * t)}


@pytest.mark.parametrize(
    ("record", "isolation"), [({}, "process"), ({"every": 7}, None), ({"keep": "last"}, None)]
)
def test_strings_are_those_of_each_point_that_is_kept(system, record, isolation, tmp_path):
    record = Record(["position.y", "position.sign"], **record)
    with prepare(system, record, isolation=isolation) as simulation:
        for _ in range(3):  # the second is repeated after a reset
            result = simulation.run(inputs=INPUT)
    expected = ["up" if y > 0.0 else "not üp" for y in result["position.y"]]
    assert result.texts == {"position.sign": expected}
    assert result.names == ("position.y",)
    with result.to_csv(tmp_path / "a.csv").open(encoding="utf-8") as file:
        assert [row["position.sign"] for row in csv.DictReader(file)] == expected
    table = parquet.read_table(result.to_parquet(tmp_path / "a.parquet"))
    assert table["position.sign"].to_pylist() == expected
    with prepare(system, "position.y") as simulation:
        every = simulation.run(inputs=INPUT)
    assert {*result["position.y"]} <= {*every["position.y"]}  # looking changes nothing


@pytest.mark.parametrize(
    ("every", "coupling", "compiled"),
    [
        *((every, coupling, False) for every in (7, N + 1) for coupling in COUPLINGS),
        *((1, "jacobi", False), (300, "gauss_seidel", True), (N, "jacobi", False)),
    ],
)
def test_every_nth_point(system, coupling, compiled, every):
    options = {"coupling": coupling, "compiled": compiled}
    full = prepare(system, **options).run(inputs=INPUT)
    thin = prepare(system, Record(["u", "*.y"], every=every), **options).run(inputs=INPUT)
    np.testing.assert_array_equal(thin.time, full.time[::every])
    for name in thin:
        np.testing.assert_array_equal(thin[name], full[name][::every])
    assert thin.names == tuple(name for name in full.names if not name.endswith(".sum"))


@pytest.mark.parametrize("coupling", COUPLINGS, ids=str)
def test_the_last_value_only(system, coupling):
    full = prepare(system, coupling=coupling).run(inputs=INPUT)
    with prepare(system, Record(keep="last"), coupling=coupling) as simulation:
        last = simulation.run(inputs=INPUT)
        halted = simulation.run(inputs=INPUT, until=3.0)
    assert last.names == full.names
    np.testing.assert_array_equal(last.values, full.values[-1:])
    np.testing.assert_array_equal(last.time, full.time[-1:])
    np.testing.assert_array_equal(halted.values, full.values[300:301])
    assert halted.time == pytest.approx([3.0])


@pytest.mark.parametrize(
    ("coupling", "every", "isolation"),
    [("gauss_seidel", 1, None), ("jacobi", 7, None), ("gauss_seidel", 7, "process")],
)
def test_the_range_of_what_is_kept(system, coupling, every, isolation):
    options = {"coupling": coupling, "isolation": isolation}
    with (
        prepare(system, Record(every=every), **options) as full,
        prepare(system, Record(every=every, keep="range"), **options) as reduced,
    ):
        for until in (None, None, 3.0):  # the second is repeated after a reset
            kept = full.run(inputs=INPUT, until=until)
            found = reduced.run(inputs=INPUT, until=until)
            assert (found.names, found.points) == (kept.names, len(kept.time))
            np.testing.assert_array_equal(found.time, kept.time[[0, -1, -1]])
            ends = kept.values.min(0), kept.values.max(0), kept.values[-1]
            np.testing.assert_array_equal(found.values, ends)


LONG = 10_000  # steps: several parts
MANY = [f"{c}.{v}" for c in ("spring", "speed", "position") for v in ("u", "k", "fault_time")]


@pytest.mark.parametrize(("isolation", "every"), [("process", 1), (None, 7)])
def test_a_file_that_is_written_as_the_run_goes(system, every, isolation, tmp_path):
    names = ["u", "*.y", "*.sum", *MANY, "position.sign"]
    how = {"step": 1e-3, "isolation": isolation}
    written, file = tmp_path / "written.csv", tmp_path / "as it goes.csv"
    with (
        system.prepare(record=Record(names, every), stop=LONG * 1e-3, **how) as full,
        system.prepare(record=Record(names, every, "range"), stop=LONG * 1e-3, **how) as reduced,
    ):
        for until in (None, None, 3.0):  # the second is repeated after a reset
            kept = full.run(inputs=INPUT, until=until)
            found = reduced.run(inputs=INPUT, until=until, out=file)
            assert file.read_bytes() == kept.to_csv(written).read_bytes()
            assert found.points == len(kept.time)
            np.testing.assert_array_equal(found.time, kept.time[[0, -1, -1]])
            ends = kept.values.min(0), kept.values.max(0), kept.values[-1]
            np.testing.assert_array_equal(found.values, ends)
            assert found.texts["position.sign"][1:] == [kept.texts["position.sign"][-1]] * 2
        full.run(inputs=INPUT, out=file)
        assert file.read_bytes() == full.run(inputs=INPUT).to_csv(written).read_bytes()


def test_parts_of_a_run_need_no_memory_for_all_of_it(make):
    """Of which the inputs are none: signals from outside are sampled before a run."""
    system = one(make("integrator"), {"u": 1.0})

    def peak(n):
        points = 0

        def take(part):
            nonlocal points
            points += len(part.time)

        record = Record(["a.y", "a.sum"], keep="range")
        with system.prepare(step=1e-3, stop=n * 1e-3, record=record) as simulation:
            tracemalloc.start()
            simulation.run(out=take)
            most = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        assert points == n + 1
        return most

    assert peak(100 * LONG) < 1.2 * peak(10 * LONG)


def test_a_run_that_begins_again_takes_back_what_it_wrote(system, tmp_path):
    def copied(part):
        return cosim.Result(part.time, part.rows.copy(), part.names, system)

    parts = []
    record = Record(["*.y", *MANY], keep="range")
    with system.prepare(step=1e-3, stop=LONG * 1e-3, record=record) as run:
        run.run(inputs=INPUT, out=lambda part: parts.append(copied(part)))
        expected = run.run(inputs=INPUT, out=tmp_path / "a.csv")
    assert len(parts) > 2
    with writing(tmp_path / "b.csv") as take:
        for part in [*parts[:2], *parts]:
            take(part)
    assert (tmp_path / "b.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()
    assert expected.points == sum(part.points for part in parts)


@pytest.mark.parametrize("isolation", [None, "process"])
def test_a_run_that_fails_leaves_the_file_as_it_was(make, isolation, tmp_path):
    system = one(make("integrator"), {"u": 1.0, "fault": GIVE_NAN, "fault_time": 45_000.0})
    file = tmp_path / "a.csv"
    file.write_text("before")
    record = Record(["a.y", "a.sum"], keep="range")
    with (
        system.prepare(step=1.0, stop=50_000.0, record=record, isolation=isolation) as simulation,
        pytest.raises(cosim.SimulationError, match="not finite"),
    ):
        simulation.run(out=file)
    assert file.read_text() == "before"
    assert [*tmp_path.glob("*.csv"), *tmp_path.glob(".*")] == [file]


def test_a_range_keeps_what_is_no_number(make):
    system = one(make("integrator"), {"u": 1.0, "fault": GIVE_NAN, "fault_time": 4.0})
    found = prepare(system, Record("a.y", keep="range"), allow_nan=True).run()
    assert np.isnan(found["a.y"][:2]).all()


@pytest.mark.parametrize("every", [1, 7])
@pytest.mark.parametrize("at", [0.455, 8.005])
def test_a_run_that_an_fmu_ends(make, at, every, tmp_path):
    system = one(make("integrator", 3), {"u": 1.0, "fault": TERMINATE, "fault_time": at})
    full = prepare(system).run()
    assert full.stopped
    some = prepare(system, Record("a.y", every=every)).run()
    last = prepare(system, Record("a.y", keep="last")).run()
    kept = sorted({*range(0, len(full.time), every), len(full.time) - 1})
    np.testing.assert_array_equal(some.time, full.time[kept])
    np.testing.assert_array_equal(some["a.y"], full["a.y"][kept])
    np.testing.assert_array_equal(last.time, full.time[-1:])
    np.testing.assert_array_equal(last["a.y"], full["a.y"][-1:])
    reduced = prepare(system, Record("a.y", every=every, keep="range")).run()
    np.testing.assert_array_equal(reduced.time, some.time[[0, -1, -1]])
    np.testing.assert_array_equal(reduced["a.y"], [*np.sort(some["a.y"])[[0, -1]], some["a.y"][-1]])
    assert reduced.points == len(kept)
    with prepare(system, Record("a.y", every=every, keep="range")) as simulation:
        simulation.run(out=tmp_path / "as it goes.csv")
    expected = some.to_csv(tmp_path / "some.csv").read_bytes()
    assert (tmp_path / "as it goes.csv").read_bytes() == expected
    assert some.stopped == last.stopped == reduced.stopped == full.stopped


def test_a_value_that_is_not_finite_is_found_though_nothing_is_kept(make):
    source = make("gain"), {"u": 1.0, "fault": GIVE_NAN, "fault_time": 4.0}
    system = joined({"a": source, "b": make("gain")}, "a.y b.u")
    for record in (Record(()), Record(keep="last")):
        with pytest.raises(
            cosim.SimulationError, match=r"^a\.y: .*not finite.* t = 4 s.*allow-nan"
        ):
            prepare(system, record).run()


@pytest.mark.parametrize(
    ("record", "message"),
    [
        ({"every": 0}, "every = 0, expected an integer from 1"),
        ({"every": 2.5}, "every = 2.5"),
        ({"keep": "first"}, "keep = 'first', expected 'all', 'last' or 'range'"),
        ({"names": "position.z"}, "no variable 'z'"),
    ],
)
def test_what_makes_no_record_is_refused(system, record, message):
    with pytest.raises(cosim.CosimError, match=message):
        prepare(system, Record(**record))


def test_an_early_return_that_was_not_allowed_is_a_failure(make):
    system = one(make("gain", 3), {"fault": RETURN_EARLY, "fault_time": 0.5})
    with pytest.raises(cosim.SimulationError, match="returned early"):
        system.prepare(step=0.1, stop=1.0).run()


@pytest.mark.parametrize("coupling", ["jacobi", "gauss_seidel"])
def test_values_that_are_not_finite_pass_where_they_are_allowed(make, version, coupling, tmp_path):
    compiled = (version, coupling) == (3, "gauss_seidel")
    source = make("integrator", version), {"u": 1.0}
    system = joined({"source": source, "gain": make("gain", version)}, "source.y gain.u")
    how = {"step": 0.1, "stop": 1.0, "coupling": coupling, "compiled": compiled}
    with system.prepare(**how, allow_nan=True) as simulation:
        result = simulation.run({"source.fault": GIVE_NAN, "source.fault_time": 0.45})
        assert np.isfinite(result["source.y"][:6]).all()
        assert np.isnan(result["source.y"][6:]).all()
        assert np.isnan(result["gain.y"][-1])
        rows = result.to_csv(tmp_path / "out.csv").read_text().splitlines()
        assert "nan" in rows[-1].split(",")
        with pytest.raises(cosim.ParameterError):
            simulation.run({"gain.k": float("nan")})
