"""Packages as other tools write them: nested, mapped, with dictionaries and variants."""

from functools import partial

import pytest
from fmpy.ssp.ssd import read_ssd

from stickslip import cosim
from stickslip.cosim.ssp import markup
from stickslip.cosim.system.scaling import Link, Scaling
from tests.corpus.fmu import archive
from tests.corpus.hostile.packages import (
    STRUCTURE,
    binding,
    bound,
    component,
    connection,
    connector,
    document,
    structure,
    system,
    values,
)
from tests.cosim.single import members

UNITS = (
    '<ssd:Units><ssc:Unit name="N"><ssc:BaseUnit kg="1" m="1" s="-2"/></ssc:Unit>'
    '<ssc:Unit name="mN"><ssc:BaseUnit kg="1" m="1" s="-2" factor="0.001"/></ssc:Unit></ssd:Units>'
)
joined = partial(connection, convert=True)
gain = partial(component, fmu="gain")
newtons = partial(connector, value='<ssc:Real unit="N"/>')


def line(factor, offset=0):
    return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'


def one(elements, *connections, **parts):
    """Return the members of a package of one description."""
    return {STRUCTURE: structure(elements, connections, rest=UNITS, times="", **parts)}


def bind(*pairs):
    """Return bindings that hold numbers by name."""
    content = f"<ssd:ParameterValues>{values(*pairs)}</ssd:ParameterValues>"
    return bound(f"<ssd:ParameterBinding>{content}</ssd:ParameterBinding>")


@pytest.fixture
def pack(make, tmp_path):
    """Write a package of given text members, with gains in N and mN, and of FMI 3.0."""

    def pack(members):
        fmus = {"gain": make("gain"), "gain3": make("gain", 3), "milli": make("gain", u="mN")}
        packed = {f"resources/{name}.fmu": fmu.read_bytes() for name, fmu in fmus.items()}
        return archive(tmp_path / "packed.ssp", members | packed)

    return pack


INNER = system(
    "inner",
    component("b", fmu="milli"),
    [joined("i", "b.u"), joined("b.y", "o", line(3, 1))],
    connectors=connector("i", "input") + connector("o", "output"),
)
OUTER = system(
    "outer",
    gain("a") + INNER,
    [joined("in", "a.u", line(2)), joined("a.y", "inner.i"), joined("inner.o", "out")],
    connectors=connector("in", "input") + connector("out", "output"),
    before='<ssd:ElementGeometry x1="0" y1="0" x2="1" y2="1"/>',
)
NESTED = one(
    OUTER + gain("c"),
    *(joined("x", "outer.in"), joined("outer.out", "c.u"), joined("c.y", "z")),
    connectors=newtons("x", "input") + newtons("z", "output"),
    behind='<ssd:Annotations><ssc:Annotation type="org.example"><any xmlns="urn:x">kept</any>'
    "</ssc:Annotation></ssd:Annotations>",
)


def end(system, name="c.y", coupling="gauss_seidel", **inputs):
    return system.prepare(step=0.25, stop=1.0, coupling=coupling).run(inputs=inputs)[name][-1]


def test_nested_systems_become_one_with_the_ways_between_them_summed_up(pack):
    system, _ = cosim.read_ssp(pack(NESTED))
    assert list(system.components) == ["outer/a", "outer/inner/b", "c"]
    assert system.connections == {"outer/inner/b.u": "outer/a.y", "c.u": "outer/inner/b.y"}
    assert system.inputs == {"x": ("outer/a.u",)}
    assert system.outputs == {"z": "c.y"}
    assert system.links["outer/a.u"] == Link(Scaling(2.0))
    assert end(system, x=1.0) == pytest.approx(3 * 2000 + 1)


def test_an_unchanged_system_is_written_as_it_was_read_to_the_byte(pack, tmp_path):
    package = pack({**NESTED, "extra/note.txt": "x", "documentation/index.html": "<p/>"})
    system, experiment = cosim.read_ssp(package)
    again = cosim.write_ssp(system, tmp_path / "again.ssp", experiment)
    assert members(again) == members(package)


def test_start_values_and_times_are_written_into_the_package(pack, tmp_path):
    system, _ = cosim.read_ssp(pack(NESTED))
    system.set("c.k", 10.0)
    system.set("outer/a.k", 3.0)
    written = cosim.write_ssp(system, tmp_path / "b.ssp", cosim.DefaultExperiment(0, 1, 0.25))
    again, experiment = cosim.read_ssp(written)
    assert again.parameters == system.parameters
    assert (again.connections, again.links) == (system.connections, system.links)
    assert experiment == cosim.DefaultExperiment(0.0, 1.0, 0.25)
    text = members(written)["SystemStructure.ssd"].decode()
    assert "kept" in text
    assert "ElementGeometry" in text
    again.set("c.k", -1.0)
    del again.parameters["outer/a.k"]
    third, _ = cosim.read_ssp(cosim.write_ssp(again, tmp_path / "c.ssp"))
    start = again.variable("outer/a.k").start
    assert third.parameters == {"c.k": -1.0, "outer/a.k": start}


def test_another_structure_is_written_from_scratch(pack, tmp_path):
    system, _ = cosim.read_ssp(pack(NESTED))
    system.add("outer/inner/d", system.components["c"], {"k": 5.0})
    del system.connections["c.u"], system.links["c.u"]
    system.connect("outer/inner/d.y", "c.u", Link(Scaling(2.0, 1.0)))
    system.connect("outer/a.y", "outer/inner/d.u")
    system.set("c.k", 10.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    for name in ("connections", "inputs", "outputs", "parameters"):
        assert getattr(again, name) == getattr(system, name)
    for target, source in system.sources().items():
        assert again.scaling(source, target) == system.scaling(source, target)
    assert end(again, x=1.0) == end(system, x=1.0) == pytest.approx(10 * (2 * 10 + 1))


def test_components_are_removed_and_replaced(pack, make, tmp_path):
    system, _ = cosim.read_ssp(pack(NESTED))
    del system.components["c"], system.connections["c.u"], system.links["c.u"]
    del system.outputs["z"]
    system.components["outer/a"] = cosim.Fmu(make("integrator"))
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert list(again.components) == ["outer/a", "outer/inner/b"]
    assert again.components["outer/a"].name == "integrator"
    assert again.outputs == {}


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_names_with_slashes_are_written_as_nested_systems(make, tmp_path, version):
    system = cosim.System("deep")
    for name in ("left/one", "left/sub/two", "right/three"):
        system.add(name, make("gain", 3 if version == "2.0" else 2), {"k": 2.0})
    system.expose("x", "left/one.u")
    system.expose_output("y", "right/three.y")
    system.connect("left/one.y", "left/sub/two.u")
    system.connect("left/sub/two.y", "right/three.u", Link(Scaling(0.5, 1.0), convert=False))
    path = cosim.write_ssp(system, tmp_path / "deep.ssp", version=version)
    again, _ = cosim.read_ssp(path)
    for name in ("connections", "links", "inputs", "outputs", "parameters"):
        assert getattr(again, name) == getattr(system, name)
    text = members(path)["SystemStructure.ssd"].decode()
    assert f'version="{version}"' in text
    assert ("ssc:Float64" in text) == (version == "2.0")
    if version == "1.0":
        assert [e.name for e in read_ssd(str(path)).system.elements] == ["left", "right"]


ENTRY = '<ssm:MappingEntry source="p.{}" target="{}"{}>{}</ssm:MappingEntry>'


def test_mapped_parameters_are_converted_and_scaled(pack):
    parameters = "".join(
        f'<ssv:Parameter name="{name}"><ssv:{value}/></ssv:Parameter>'
        for name, value in [
            ("force", 'Real value="2" unit="N"'),
            ("mode", 'Enumeration value="fast" name="E"'),
            ("on", 'Boolean value="true"'),
        ]
    )
    defined = (
        '<ssv:Enumerations><ssc:Enumeration name="E"><ssc:Item name="slow" value="1"/>'
        '<ssc:Item name="fast" value="7"/></ssc:Enumeration></ssv:Enumerations>'
    ) + UNITS.replace("ssd:", "ssv:")
    entries = (
        ENTRY.format("force", "u", "", line(1, 5))
        + ENTRY.format("force", "k", ' suppressUnitConversion="true"', line(3))
        + ENTRY.format("mode", "n", "", "")
        + ENTRY.format("on", "flag", "", "")
        + '<ssm:MappingEntry source="" target="fault"/>'  # keeps its value
    )
    bindings = binding("resources/a.ssv", "resources/a.ssm").replace(
        'source="resources/a.ssv"', 'source="resources/a.ssv" prefix="p."'
    )
    members = one(component("a", bindings, fmu="milli")) | {
        "resources/a.ssv": document(
            "ssv:ParameterSet", f"<ssv:Parameters>{parameters}</ssv:Parameters>{defined}"
        ),
        "resources/a.ssm": document("ssm:ParameterMapping", entries),
    }
    system, _ = cosim.read_ssp(pack(members))
    assert system.parameters == {"a.u": 2005.0, "a.k": 6.0, "a.n": 7, "a.flag": True}


def test_outer_bindings_go_before_inner_ones_and_reach_in_by_name_and_connector(pack, tmp_path):
    inner = system("inner", gain("a"), before=bind(("a.k", 1), ("a.fault_time", 9)))
    end = f"<ssd:Connectors>{connector('k', 'parameter')}</ssd:Connectors>"
    members = one(
        inner + gain("b", end),
        joined("gain", "b.k", line(10)),
        connectors=connector("gain", "parameter"),
        before=bind(("inner.a.k", 2), ("gain", 4)),
    )
    read, _ = cosim.read_ssp(pack(members))
    assert read.parameters == {"inner/a.k": 2.0, "inner/a.fault_time": 9.0, "b.k": 40.0}
    read.set("inner/a.k", 3.0)
    read.set("b.k", 5.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(read, tmp_path / "b.ssp"))
    assert again.parameters == read.parameters


BUS = '<ssd:SignalDictionaryReference name="bus" dictionary="D">{}</ssd:SignalDictionaryReference>'
DICTIONARY = one(
    gain("a")
    + component("b", fmu="milli")
    + BUS.format(f"<ssd:Connectors>{connector('force', 'inout')}</ssd:Connectors>")
    + system("inner", gain("c") + BUS.format(""), [joined("c.u", "bus.force")]),
    joined("a.y", "bus.force"),
    joined("bus.force", "b.u"),
    behind='<ssd:SignalDictionaries><ssd:SignalDictionary name="D" source="resources/d.ssb"/>'
    "</ssd:SignalDictionaries>",
) | {
    "resources/d.ssb": document(
        "ssb:SignalDictionary",
        '<ssb:DictionaryEntry name="force"><ssc:Real unit="N"/></ssb:DictionaryEntry>',
    )
}


def test_a_signal_dictionary_is_a_bus_across_systems(pack, tmp_path):
    system, _ = cosim.read_ssp(pack(DICTIONARY))
    assert system.connections == {"b.u": "a.y", "inner/c.u": "a.y"}
    assert system.links == {}
    system.expose("x", "a.u")
    assert end(system, "b.y", x=2.0) == pytest.approx(2000.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert (again.connections, again.inputs) == (system.connections, system.inputs)


def test_variants_are_listed_and_chosen_by_name_or_file(pack, tmp_path):
    other = structure(gain("b"), times="", name="other")
    package = pack(one(gain("a")) | {"light.ssd": other})
    assert cosim.variants(package) == ["n", "other"]
    assert list(cosim.read_ssp(package)[0].components) == ["a"]
    for variant in ("other", "light.ssd"):
        system, _ = cosim.read_ssp(package, variant)
        assert list(system.components) == ["b"]
    system.set("b.k", 3.0)
    written = cosim.write_ssp(system, tmp_path / "b.ssp")
    assert cosim.read_ssp(written, "other")[0].parameters == {"b.k": 3.0}
    assert cosim.read_ssp(written)[0].parameters == {}
    with pytest.raises(cosim.SspError, match="no variant 'othr'; did you mean 'other'"):
        cosim.read_ssp(package, "othr")


def test_a_system_may_lie_in_a_file_of_its_own(pack, tmp_path):
    nested = '<ssd:Component name="n" type="application/x-ssp-definition" source="{}"/>'
    inner = structure(
        gain("a").replace("resources/", ""),
        [joined("i", "a.u")],
        connectors=connector("i", "input"),
        rest=UNITS,
        times="",
    )
    outer = one(
        nested.format("resources/inner.ssd"), joined("x", "n.i"), connectors=connector("x", "input")
    )
    system, _ = cosim.read_ssp(pack(outer | {"resources/inner.ssd": inner}))
    assert system.inputs == {"x": ("n/a.u",)}
    assert end(system, "n/a.y", x=2.0) == 2.0
    system.set("n/a.k", 3.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert again.parameters == {"n/a.k": 3.0}


def test_versions_turn_into_each_other_where_they_can(pack, tmp_path):
    ends = f"<ssd:Connectors>{connector('u', 'input', '<ssc:Float64/>')}</ssd:Connectors>"
    two = component("a", ends, fmu="gain3")
    system, _ = cosim.read_ssp(pack(one(two, version="2.0")))
    old = cosim.write_ssp(system, tmp_path / "old.ssp", version="1.0")
    read_ssd(str(old))
    new = cosim.write_ssp(cosim.read_ssp(old)[0], tmp_path / "new.ssp", version="2.0")
    assert 'version="2.0"' in members(new)[STRUCTURE].decode()


def test_without_the_schema_of_2_nothing_is_said_to_be_allowed_there(pack, monkeypatch):
    ends = f"<ssd:Connectors>{connector('u', 'input', '<ssc:Float64/>')}</ssd:Connectors>"
    file = pack(one(component("a", ends, fmu="gain")))
    old = markup._schema
    for known in (True, False):
        with pytest.raises(cosim.SspError) as caught:
            cosim.read_ssp(file)
        assert ("set version='2.0'" in str(caught.value)) == known
        monkeypatch.setattr(markup, "_schema", lambda part, v: old(part, v) if v == "1.0" else None)
