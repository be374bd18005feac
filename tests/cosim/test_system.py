"""A system refuses what cannot be, names both ends, and converts units."""

import math
import shutil

import cloudpickle
import pytest

from stickslip import cosim
from stickslip.cosim.system.scaling import PLAIN, Link, Scaling
from stickslip.fmi.description.units import Unit
from tests.cosim.single import joined, one


@pytest.fixture
def system(make):
    return joined({"drive": make("integrator"), "controller": make("gain")})


@pytest.mark.parametrize(
    ("source", "target", "message"),
    [
        ("drive.yy", "controller.u", r"cannot connect drive\.yy to controller\.u.*mean 'y'"),
        ("drove.y", "controller.u", "has no component 'drove'.*mean 'drive'"),
        ("drive.y", "controller.w", "no variable 'w'; there is u, y"),
        ("drive.u", "controller.u", r"drive\.u is a Real input, expected an output"),
        ("drive.y", "controller.k", r"controller\.k is a Real parameter, expected .* input"),
        ("drive.y", "controller.n", r"controller\.n is a Integer parameter"),
        ("drive", "controller.u", "no variable ''"),
        ("drive.y", "u", r"'u' is one of several: drive\.u, controller\.u"),
    ],
)
def test_impossible_connections(system, source, target, message):
    with pytest.raises(cosim.ConnectionFault, match=message):
        system.connect(source, target)


def test_an_fmu_whose_file_was_written_again_is_another(make, tmp_path):
    path = shutil.copy(make("integrator"), tmp_path / "one.fmu")
    system = joined({"one": path})
    kept = cloudpickle.dumps(system)
    assert cloudpickle.loads(kept).components["one"].variables
    shutil.copy(make("gain"), path)
    for use in (
        lambda: cloudpickle.loads(kept),
        lambda: cosim.write_ssp(system, tmp_path / "a.ssp"),
    ):
        with pytest.raises(
            cosim.CosimError, match=r"one\.fmu: was written again since it was read"
        ):
            use()


def test_an_input_has_one_source(system):
    system.connect("drive.y", "controller.u")
    with pytest.raises(cosim.ConnectionFault, match=r"already connected to drive\.y"):
        system.connect("controller.y", "controller.u")
    with pytest.raises(cosim.ConnectionFault, match=r"already connected to drive\.y"):
        system.expose("x", "controller.u")
    system.expose("force", "drive.u")
    with pytest.raises(cosim.ConnectionFault, match="already connected to force"):
        system.connect("controller.y", "drive.u")


def test_units_must_measure_the_same(make):
    units = {"same": "kg.m/s2", "milli": "mN", "length": "m"}
    gains = {name: make("gain", u=unit) for name, unit in units.items()}
    system = joined({"force": make("gain"), **gains}, "force.y same.u")
    with pytest.raises(cosim.ConnectionFault, match=r"force\.y is in 'N', length\.u in 'm'"):
        system.connect("force.y", "length.u")
    with pytest.raises(cosim.ConnectionFault, match=r"'mN'.*'m'"):
        system.expose("both", "milli.u", "length.u")
    assert system.inputs == {}
    system.add("f", cosim.Function(lambda _, u: u, {"u": "kgf"}, {"y": None}))
    with pytest.raises(cosim.ConnectionFault, match="'kgf' by base units; scale it by a Link"):
        system.connect("force.y", "f.u")


@pytest.mark.parametrize("name", ["", "a.b", "drive"])
def test_what_cannot_be_added_is_not(system, make, name):
    said = "already has a component 'drive'" if name == "drive" else "it is empty or has a dot"
    with pytest.raises(cosim.ConnectionFault, match=said):
        system.add(name, make("gain"))
    with pytest.raises(cosim.ParameterError, match=r"no variable 'kk'; did you mean 'k'"):
        system.add("third", make("gain"), {"kk": 1.0})
    assert list(system.components) == ["drive", "controller"]
    if name != "drive":
        with pytest.raises(cosim.ConnectionFault, match=said):
            system.expose(name, "drive.u")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("drive.q", 1.0, "no variable 'q'"),
        ("drove.k", 1.0, "did you mean 'drive'"),
        ("drive.K", 1.0, r"did you mean 'k'\?"),
        ("drive.k", 1001.0, r"drive\.k = 1001\.0 is outside its range -1000\.0 to 1000\.0"),
        ("drive.fault_time", math.inf, "outside its range"),
        ("drive.k", math.nan, "outside its range"),
        ("drive.k", "much", "expected a value of type Real, got 'much'"),
        ("drive.n", 1.5, "expected a value of type Integer"),
        ("drive.n", 10, "outside its range"),
        ("drive.fault", 2**31, "expected a value of type Integer"),
        ("drive.flag", 2, "expected a value of type Boolean"),
        ("drive.text", 2, "expected a value of type String"),
        ("drive.y", 1.0, "cannot be set: it is a continuous output"),
    ],
)
def test_start_values_that_cannot_be(system, name, value, message):
    with pytest.raises(cosim.ParameterError, match=message):
        system.set(name, value)


def test_an_algebraic_loop_is_named(make):
    system = joined(dict.fromkeys("abc", make("gain")), "a.y b.u", "b.y c.u", "c.y a.u", name="")
    with pytest.raises(cosim.ConnectionFault) as error:
        system.prepare(step=0.1, stop=1.0)
    loop = str(error.value).removeprefix("algebraic loop ").partition(":")[0].split(" -> ")
    assert len(loop) == 6
    assert set(loop) == {"a.y", "b.u", "b.y", "c.u", "c.y", "a.u"}
    for source, target in zip(loop[::2], loop[1::2], strict=True):
        assert system.connections[target] == source
    for remedy in ("a (gain.fmu)", "canGetAndSetFMUstate", "coupling='jacobi'"):
        assert remedy in str(error.value)
    system.prepare(step=0.1, stop=1.0, coupling="jacobi").run()


NEWTON = Unit("N", (1, 1, -2, 0, 0, 0, 0, 0))
KELVIN = Unit("K", (0, 0, 0, 0, 1, 0, 0, 0))
CELSIUS = Unit("degC", KELVIN.exponents, 1.0, 273.15)
FAHRENHEIT = Unit("degF", KELVIN.exponents, 5 / 9, 273.15 - 32 * 5 / 9)


def two_gains(make, source, target, link=PLAIN):
    parts = {"a": (make("gain", y=source), {"k": 2.0}), "b": make("gain", 3, u=target)}
    system = joined(parts, x="a.u")
    system.connect("a.y", "b.u", link)
    return system


def end(system, **inputs):
    return system.prepare(step=0.5, stop=1.0).run(inputs=inputs)["b.y"][-1]


def test_an_exposed_input_has_one_unit_and_feeds_targets_in_theirs(make):
    system = joined({"a": make("gain"), "b": make("gain", u="mN")}, x="a.u b.u")
    assert end(system, x=2.0) == pytest.approx(2000.0)
    other = one(make("gain", u="mN"), {"u": 7000.0}, name="b")
    other.expose("x", "b.u", unit=NEWTON)
    assert other.unit("x") == "N"
    assert end(other) == pytest.approx(7000.0)  # the start value of the target, through its unit


def test_a_scaling_comes_after_the_units_or_in_their_place(make):
    line = Scaling(factor=10.0, offset=1.0)
    assert end(two_gains(make, "mN", "N", Link(line)), x=3.0) == pytest.approx(0.06 + 1)
    assert end(two_gains(make, "mN", "N", Link(line, convert=False)), x=3.0) == 61.0
    assert end(two_gains(make, "m", "N", Link(convert=False)), x=3.0) == 6.0


@pytest.mark.parametrize(
    ("source", "target", "of_20"),
    [
        ("degC difference", "K difference", 20.0),
        ("K difference", "degC difference", 20.0),
        ("degF difference", "degC difference", 20.0 * 5 / 9),
        ("degC difference", "degF difference", 36.0),
        ("degC", "K", 293.15),
        ("degF", "degC", -20.0 / 3),
        ("degC difference", "degC", 20.0),  # the same unit: the number stays
        ("mN difference", "N", 0.02),  # without an offset there is nothing to confuse
        ("N", "mN difference", 20e3),
    ],
)
def test_no_offset_applies_to_a_difference(make, source, target, of_20):
    """20 degC of difference are 20 K; said by the variable (FMI 2.0) or its type (FMI 3.0)."""
    assert end(two_gains(make, source, target), x=10.0) == pytest.approx(of_20, rel=1e-12)


@pytest.mark.parametrize(
    ("source", "target"),
    [("degC difference", "K"), ("K", "degC difference"), ("degF", "degC difference")],
)
def test_a_difference_is_no_temperature(make, source, target):
    with pytest.raises(cosim.ConnectionFault, match=r"as a difference \(relativeQuantity\).*Link"):
        two_gains(make, source, target)
    as_meant = Link(Scaling(), convert=False)
    assert end(two_gains(make, source, target, as_meant), x=10.0) == 20.0


def test_a_unit_from_outside_is_for_what_its_target_is(make):
    """An exposed input in another unit is a difference where its first target is one."""
    for unit, target, of_20 in (
        (FAHRENHEIT, "degC difference", 20.0 * 5 / 9),
        (CELSIUS, "K difference", 20.0),
        (CELSIUS, "K", 293.15),
    ):
        system = one(make("gain", 2, u=target), name="b")
        system.expose("x", "b.u", unit=unit)
        assert end(system, x=20.0) == pytest.approx(of_20, rel=1e-12)
        start = system.copy()
        start.set("b.u", of_20)
        assert end(start) == pytest.approx(of_20, rel=1e-12)
    system = joined({"a": make("gain", 2, u="K difference"), "b": make("gain", 2, u="K")})
    with pytest.raises(cosim.ConnectionFault, match="as a difference"):
        system.expose("x", "a.u", "b.u", unit=CELSIUS)


def test_a_container_says_that_its_signals_are_differences(make, tmp_path):
    system = one(make("gain", 2, u="degC difference", y="degC"), u="u")
    variables = cosim.Fmu(cosim.write_fmu(system, tmp_path / "a.fmu", step=0.1, fmi=3)).variables
    assert [n for n, v in variables.items() if v.relative] == ["u"]
