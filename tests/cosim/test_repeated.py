"""Each run of a prepared simulation is that of a new simulation, whatever a reset does."""

import functools
import tempfile
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.run import resets
from tests.corpus import fmu
from tests.cosim.single import joined, one

pytestmark = pytest.mark.slow

STEP, STOP = 0.05, 0.5  # 10 steps; see unreset.c
SOUND, MISSING = ".", "?"
RESETS = {
    "does nothing": "-",
    "keeps what cannot be seen": "z",
    "keeps its time": "t",
    "keeps what shows late": "n",
    "loses the start values of parameters": "K",
    "loses the start values of inputs": "U",
    "keeps parameters": "k",
    "returns an error": "3",
    "returns discard": "2",
    "returns fatal": "4",
    "does not exist": MISSING,
}
RUNS = [{"a.k": 2.0}, {"a.k": 2.0}, {"a.k": 5.0}, {}, {"a.k": 2.0}]


@pytest.fixture(autouse=True)
def nothing_known(monkeypatch):
    """What is known of FMUs is known for good; here each test begins without."""
    monkeypatch.setattr(resets, "lines", {})
    monkeypatch.setattr(resets, "crashed", set())


@pytest.fixture(scope="module")
def write(tmp_path_factory):
    """Write the FMU of unreset.c: ``write("a", 2, "z")``, whose reset keeps z."""
    folder = tmp_path_factory.mktemp("unreset")

    @functools.cache
    def write(name, version, plan, flags=""):
        options = ["-DWITHOUT_RESET", "-Wno-unused-function"] if plan == MISSING else []
        source = Path(__file__).with_name("unreset.c")
        binary = fmu.library("unreset", source, flags=options, complete=False).read_bytes()
        variables = [
            fmu.Variable("u", "input", 1),
            fmu.Variable("y", "output", depends=()),
            fmu.Variable("k", "parameter", 0.1, variability="tunable"),
        ]
        interface = f'{flags} canHandleVariableCommunicationStepSize="true"'
        kinds = {"CoSimulation": interface}
        description = fmu.describe("unreset", version, variables, kinds, token=plan)
        path = Path(tempfile.mkdtemp(dir=folder)) / f"{name}.fmu"
        return fmu.pack(path, description, {fmu.place("unreset", version): binary})

    return write


def alone(fmu, *, exposed=True):
    return one(fmu, u="u" if exposed else "")


def fresh(system, parameters=None, inputs=None, tunable=None, **options):
    """Return the result of a simulation that is new."""
    with system.prepare(step=STEP, stop=STOP, **options) as simulation:
        return simulation.run(parameters, inputs, tunable=tunable)


def same(result, expected):
    np.testing.assert_array_equal(result.time, expected.time)
    np.testing.assert_array_equal(result.values, expected.values)


def lines(caplog):
    return [r.getMessage() for r in caplog.records if "cannot be used again" in r.getMessage()]


@pytest.mark.parametrize(
    ("what", "version", "isolation"),
    [
        *((what, version, None) for what in RESETS for version in (2, 3)),
        # a child runs the same code with either version
        *((what, 2 + place % 2, "process") for place, what in enumerate([*RESETS][::3])),
    ],
)
def test_every_run_is_that_of_a_new_simulation(write, version, what, isolation, caplog):
    system = alone(write("a", version, RESETS[what]), exposed=False)
    expected = [fresh(system, parameters) for parameters in RUNS]
    for _ in range(2):
        with system.prepare(step=STEP, stop=STOP, isolation=isolation) as simulation:
            for parameters, values in zip(RUNS, expected, strict=True):
                same(simulation.run(parameters), values)
    (line,) = lines(caplog)
    assert line.startswith("a (a.fmu) cannot be used again after a reset: ")
    assert line.endswith("; each run has a new instance of it")


def test_a_sound_reset_is_used(write, version, caplog):
    """Instances are told by the noise: each has another."""
    system = alone(write("a", version, "ki"))
    with system.prepare(step=STEP, stop=STOP) as simulation:
        results = [simulation.run({"a.k": 1.0}).values for _ in range(20)]
    for values in results:
        np.testing.assert_array_equal(values, results[0])
    assert not caplog.records
    born = system.prepare(step=STEP, stop=STOP).run()["a.y"][1]
    assert round(born / STEP - 0.1) == 3  # two, and one that is new here


@pytest.mark.parametrize("first", ["a", "b"])
def test_who_is_named_in_a_loop(write, version, first, caplog):
    parts = dict.fromkeys("ab", write("b", version, SOUND))
    parts[first] = write("broken", version, RESETS["keeps its time"])
    system = joined(parts, "a.y b.u", "b.y a.u")
    for coupling in ("jacobi", "gauss_seidel"):
        expected = fresh(system, {"a.k": 1.0}, coupling=coupling)
        with system.prepare(step=STEP, stop=STOP, coupling=coupling) as simulation:
            for _ in range(4):
                same(simulation.run({"a.k": 1.0}), expected)
    (line,) = lines(caplog)
    assert line.startswith(f"{first} (broken.fmu)")


def test_a_first_run_at_rest_proves_nothing(write, version, caplog):
    """Without input and start value nothing happens that a reset could undo."""
    system = alone(write("a", version, "xz"))
    rest, moves = {"u": 0.0}, {"u": 2.0}
    parameters = {"a.k": 1.0}
    short = {"step": STEP, "stop": 0.3}
    expected = []
    for inputs in (rest, moves):
        with system.prepare(**short) as simulation:
            expected.append(simulation.run(parameters, inputs))
    with system.prepare(**short) as simulation:
        for i in (0, 0, 1, 1, 0, 1):
            same(simulation.run(parameters, [rest, moves][i]), expected[i])
    assert len(lines(caplog)) == 1


def test_parameters_that_changed_in_a_run(write, version, caplog):
    system = alone(write("a", version, RESETS["keeps parameters"]))
    k = system.variable("a.k").start
    change = {"a.k": cosim.Table([0.0, 0.2], [k, 3.0], held=True)}
    expected = [fresh(system), fresh(system, tunable=change)]
    with system.prepare(step=STEP, stop=STOP) as simulation:
        for changes in (True, False, True, True, False):
            same(simulation.run(tunable=change if changes else None), expected[changes])
    assert len(lines(caplog)) == 1


def test_after_a_run_that_was_halted(write, version):
    system = alone(write("a", version, "h"))
    expected = fresh(system)
    with system.prepare(step=STEP, stop=STOP) as simulation:
        for until in (None, None, 0.3, None, 0.3, None):
            same_until = len(expected.time) if until is None else 7
            values = simulation.run(until=until).values
            np.testing.assert_array_equal(values, expected.values[:same_until])


def test_an_fmu_that_is_not_deterministic_is_not_blamed_for_its_reset(write, version, caplog):
    system = alone(write("a", version, "+i"))
    with system.prepare(step=STEP, stop=STOP) as simulation:
        for _ in range(5):
            simulation.run()
    (record,) = caplog.records
    assert record.getMessage().startswith(
        "a (a.fmu) gives other results in the same run with another new instance: a.y is "
    )


@pytest.mark.parametrize(("version", "isolation"), [(2, None), (3, "process")])
def test_static_variables_are_told(write, version, isolation, caplog):
    """From the second instance on all are alike, and unlike the first."""
    system = alone(write("a", version, "s"))
    with system.prepare(step=STEP, stop=STOP, isolation=isolation) as simulation:
        for _ in range(4):
            simulation.run()
    (record,) = caplog.records
    assert "each run needs a process of its own" in record.getMessage()
    if isolation:
        with system.prepare(step=STEP, stop=STOP, isolation=isolation) as simulation:
            results = []
            for _ in range(3):
                results.append(simulation.run().values)
                simulation.close()
        for values in results:
            np.testing.assert_array_equal(values, results[0])


ONCE = 'canBeInstantiatedOnlyOncePerProcess="true"'


@pytest.mark.parametrize(
    ("version", "plan", "flags", "isolation", "told"),
    [
        *((version, RESETS["does nothing"], ONCE, None, "after a reset") for version in (2, 3)),
        (3, "!", "", "process", "fmi3Reset died of SIGSEGV"),
        # no second instance can be made, and perhaps the first cannot be reset
        *((2, "c", "", "process", None), (3, "!c", "", "process", None)),
    ],
)
def test_what_cannot_be_used_again_costs_no_run(
    write, version, plan, flags, isolation, told, caplog
):
    """One instance in a process, a crash on reset, and what crashes a used process."""
    system = alone(write("a", version, plan, flags=flags))
    expected = fresh(system)
    for first in (True, False):
        with system.prepare(step=STEP, stop=STOP, isolation=isolation) as simulation:
            for _ in range(4):
                same(simulation.run(), expected)
        if told and first:
            (line,) = lines(caplog)
            assert told in line
