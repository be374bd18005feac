"""Packages as other tools write them: nested, mapped, with dictionaries and variants."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssd

from stickslip import cosim
from stickslip.cosim.system.scaling import PLAIN, Link, Scaling

ROOT = (
    '<?xml version="1.0" encoding="UTF-8"?><ssd:SystemStructureDescription'
    ' xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"'
    ' xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"'
    ' xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"'
    ' xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"'
    ' xmlns:ssb="http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"'
)
UNITS = (
    '<ssd:Units><ssc:Unit name="N"><ssc:BaseUnit kg="1" m="1" s="-2"/></ssc:Unit>'
    '<ssc:Unit name="mN"><ssc:BaseUnit kg="1" m="1" s="-2" factor="0.001"/></ssc:Unit></ssd:Units>'
)


def structure(body, version="1.0", name="whole", rest=UNITS):
    return (
        f'{ROOT} version="{version}" name="{name}"><ssd:System name="{name}">{body}</ssd:System>'
        f"{rest}</ssd:SystemStructureDescription>"
    )


def component(name, content="", source="gain.fmu"):
    return f'<ssd:Component name="{name}" source="resources/{source}">{content}</ssd:Component>'


def connector(name, kind, unit="", content=""):
    unit = unit and f' unit="{unit}"'
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real{unit}/>{content}</ssd:Connector>'


def connectors(*items):
    return f"<ssd:Connectors>{''.join(items)}</ssd:Connectors>"


def connections(*items):
    joined = []
    for start, end, *rest in items:
        attributes = ""
        for which, text in (("start", start), ("end", end)):
            element, _, name = text.rpartition(".")
            attributes += f' {which}Connector="{name}"'
            attributes += f' {which}Element="{element}"' if element else ""
        attributes += rest[1] if len(rest) > 1 else ""
        joined.append(f"<ssd:Connection{attributes}>{rest[0] if rest else ''}</ssd:Connection>")
    return f"<ssd:Connections>{''.join(joined)}</ssd:Connections>"


def elements(*items):
    return f"<ssd:Elements>{''.join(items)}</ssd:Elements>"


def line(factor, offset=0):
    return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'


@pytest.fixture
def pack(make, tmp_path):
    """Write a package of given text members, with gains in N, mN and FMI 3.0."""

    def pack(members, name="packed.ssp"):
        path = tmp_path / name
        with zipfile.ZipFile(path, "w") as archive:
            for member, text in members.items():
                archive.writestr(member, text)
            archive.write(make("gain"), "resources/gain.fmu")
            archive.write(make("gain", 2, u="mN"), "resources/milli.fmu")
            archive.write(make("gain", 2, u="m", y="m"), "resources/metres.fmu")
            archive.write(make("gain", 3), "resources/gain3.fmu")
            archive.write(make("integrator"), "resources/integrator.fmu")
        return path

    return pack


def one(body, **rest):
    return {"SystemStructure.ssd": structure(body, **rest)}


NESTED = (
    connectors(connector("x", "input", "N"), connector("z", "output", "N"))
    + elements(
        '<ssd:System name="outer">'
        + connectors(connector("in", "input"), connector("out", "output"))
        + '<ssd:ElementGeometry x1="0" y1="0" x2="1" y2="1"/>'
        + elements(
            component("a"),
            '<ssd:System name="inner">'
            + connectors(connector("i", "input"), connector("o", "output"))
            + elements(component("b", source="milli.fmu"))
            + connections(("i", "b.u"), ("b.y", "o", line(3, 1)))
            + "</ssd:System>",
        )
        + connections(("in", "a.u", line(2)), ("a.y", "inner.i"), ("inner.o", "out"))
        + "</ssd:System>",
        component("c"),
    )
    + connections(("x", "outer.in"), ("outer.out", "c.u"), ("c.y", "z"))
    + '<ssd:Annotations><ssc:Annotation type="org.example"><any xmlns="urn:x">kept</any>'
    "</ssc:Annotation></ssd:Annotations>"
)


def end(system, name="c.y", coupling="gauss_seidel", **inputs):
    with system.prepare(step=0.25, stop=1.0, coupling=coupling) as simulation:
        return simulation.run(inputs=inputs)[name][-1]


def test_nested_systems_become_one_with_the_ways_between_them_summed_up(pack):
    system, _ = cosim.read_ssp(pack(one(NESTED)))
    assert list(system.components) == ["outer/a", "outer/inner/b", "c"]
    assert system.connections == {"outer/inner/b.u": "outer/a.y", "c.u": "outer/inner/b.y"}
    assert system.inputs == {"x": ("outer/a.u",)}
    assert system.outputs == {"z": "c.y"}
    assert system.links["outer/a.u"] == Link(Scaling(2.0))
    assert end(system, x=1.0) == pytest.approx(3 * 2000 + 1)


def members_of(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_an_unchanged_system_is_written_as_it_was_read_to_the_byte(pack, tmp_path):
    package = pack({**one(NESTED), "extra/note.txt": "x", "documentation/index.html": "<p/>"})
    system, experiment = cosim.read_ssp(package)
    again = cosim.write_ssp(system, tmp_path / "again.ssp", experiment)
    assert members_of(again) == members_of(package)


def test_a_change_is_written_into_the_nesting_and_keeps_what_is_not_known(pack, tmp_path):
    system, _ = cosim.read_ssp(pack(one(NESTED)))
    system.add("outer/inner/d", system.components["c"], {"k": 5.0})
    del system.connections["c.u"], system.links["c.u"]
    system.connect("outer/inner/d.y", "c.u", Link(Scaling(2.0, 1.0)))
    system.connect("outer/a.y", "outer/inner/d.u")
    system.set("c.k", 10.0)
    written = cosim.write_ssp(system, tmp_path / "b.ssp", cosim.DefaultExperiment(0, 1, 0.25))
    again, experiment = cosim.read_ssp(written)
    assert again.connections == system.connections
    assert again.links == system.links
    assert again.parameters == system.parameters
    assert again.outputs == system.outputs
    assert experiment.step == 0.25
    assert end(again, x=1.0) == end(system, x=1.0) == pytest.approx(10 * (2 * 10 + 1))
    text = members_of(written)["SystemStructure.ssd"].decode()
    assert "kept" in text
    assert "ElementGeometry" in text
    again.set("c.k", -1.0)  # in place this time: no binding is added
    third = cosim.write_ssp(again, tmp_path / "c.ssp")
    assert members_of(third).keys() == members_of(written).keys()
    assert cosim.read_ssp(third)[0].parameters["c.k"] == -1.0


def test_components_are_removed_and_replaced(pack, make, tmp_path):
    system, _ = cosim.read_ssp(pack(one(NESTED)))
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
    text = members_of(path)["SystemStructure.ssd"].decode()
    assert f'version="{version}"' in text
    assert ("ssc:Float64" in text) == (version == "2.0")
    if version == "1.0":
        assert [e.name for e in read_ssd(str(path)).system.elements] == ["left", "right"]


def mapped(entry):
    return {
        **one(
            elements(
                component(
                    "a",
                    '<ssd:ParameterBindings><ssd:ParameterBinding source="resources/a.ssv"'
                    ' prefix="p."><ssd:ParameterMapping source="resources/a.ssm"/>'
                    "</ssd:ParameterBinding></ssd:ParameterBindings>",
                    source="milli.fmu",
                )
            )
        ),
        "resources/a.ssv": ROOT.replace("ssd:SystemStructureDescription", "ssv:ParameterSet")
        + ' version="1.0" name="a"><ssv:Parameters>'
        '<ssv:Parameter name="force"><ssv:Real value="2" unit="N"/></ssv:Parameter>'
        '<ssv:Parameter name="mode"><ssv:Enumeration value="fast" name="E"/></ssv:Parameter>'
        '<ssv:Parameter name="on"><ssv:Boolean value="true"/></ssv:Parameter>'
        '</ssv:Parameters><ssv:Enumerations><ssc:Enumeration name="E">'
        '<ssc:Item name="slow" value="1"/><ssc:Item name="fast" value="7"/></ssc:Enumeration>'
        '</ssv:Enumerations><ssv:Units><ssc:Unit name="N">'
        '<ssc:BaseUnit kg="1" m="1" s="-2"/></ssc:Unit></ssv:Units></ssv:ParameterSet>',
        "resources/a.ssm": ROOT.replace("ssd:SystemStructureDescription", "ssm:ParameterMapping")
        + f' version="1.0">{entry}</ssm:ParameterMapping>',
    }


ENTRY = '<ssm:MappingEntry source="p.{}" target="{}"{}>{}</ssm:MappingEntry>'


def test_mapped_parameters_are_converted_scaled_and_looked_up(pack):
    flip = (
        '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/>'
        '<ssc:MapEntry source="false" target="true"/></ssc:BooleanMappingTransformation>'
    )
    entries = (
        ENTRY.format("force", "u", "", line(1, 5))
        + ENTRY.format("force", "k", ' suppressUnitConversion="true"', line(3))
        + ENTRY.format("mode", "n", "", "")
        + ENTRY.format("on", "flag", "", flip)
    )
    system, _ = cosim.read_ssp(pack(mapped(entries)))
    assert system.parameters == {"a.u": 2005.0, "a.k": 6.0, "a.n": 7, "a.flag": False}


def test_a_mapping_of_nothing_is_refused_with_its_line(pack):
    with pytest.raises(
        cosim.SspError, match=r"a\.ssm, line 1: .*'p\.farce'; did you mean 'p.force"
    ):
        cosim.read_ssp(pack(mapped(ENTRY.format("farce", "u", "", ""))))


def bind(*values):
    parameters = "".join(
        f'<ssv:Parameter name="{name}"><ssv:Real value="{value}"/></ssv:Parameter>'
        for name, value in values
    )
    return (
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>"
        f'<ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>{parameters}</ssv:Parameters>'
        "</ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def test_outer_bindings_go_before_inner_ones_and_reach_in_by_name_and_connector(pack, tmp_path):
    body = (
        connectors(connector("gain", "parameter"))
        + bind(("inner.a.k", 2), ("gain", 4))
        + elements(
            '<ssd:System name="inner">'
            + bind(("a.k", 1), ("a.fault_time", 9))
            + elements(component("a"))
            + "</ssd:System>",
            component("b", connectors(connector("k", "parameter"))),
        )
        + connections(("gain", "b.k", line(10)))
    )
    system, _ = cosim.read_ssp(pack(one(body)))
    assert system.parameters == {"inner/a.k": 2.0, "inner/a.fault_time": 9.0, "b.k": 40.0}
    system.set("inner/a.k", 3.0)
    system.set("b.k", 5.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert again.parameters == system.parameters


DICTIONARY = (
    elements(
        component("a"),
        component("b", source="milli.fmu"),
        '<ssd:SignalDictionaryReference name="bus" dictionary="D">'
        + connectors(connector("force", "inout"))
        + "</ssd:SignalDictionaryReference>",
        '<ssd:System name="inner">'
        + elements(
            component("c"),
            '<ssd:SignalDictionaryReference name="bus" dictionary="D"/>',
        )
        + connections(("c.u", "bus.force"))
        + "</ssd:System>",
    )
    + connections(("a.y", "bus.force"), ("bus.force", "b.u"))
    + '<ssd:SignalDictionaries><ssd:SignalDictionary name="D" source="resources/d.ssb"/>'
    "</ssd:SignalDictionaries>"
)
ENTRIES = (
    ROOT.replace("ssd:SystemStructureDescription", "ssb:SignalDictionary")
    + ' version="1.0"><ssb:DictionaryEntry name="force"><ssc:Real unit="N"/></ssb:DictionaryEntry>'
    "</ssb:SignalDictionary>"
)


def test_a_signal_dictionary_is_a_bus_across_systems(pack, tmp_path):
    package = pack({**one(DICTIONARY), "resources/d.ssb": ENTRIES})
    system, _ = cosim.read_ssp(package)
    assert system.connections == {"b.u": "a.y", "inner/c.u": "a.y"}
    assert system.links == {}
    system.expose("x", "a.u")
    assert end(system, "b.y", x=2.0) == pytest.approx(2000.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert (again.connections, again.inputs) == (system.connections, system.inputs)


def test_a_change_that_would_break_the_package_is_refused(pack, tmp_path):
    """An outer binding names the component that is gone."""
    body = bind(("a.k", 2)) + elements(component("a"), component("b"))
    system, _ = cosim.read_ssp(pack(one(body)))
    del system.components["a"], system.parameters["a.k"]
    with pytest.raises(cosim.SspError, match=r"would be broken: .*no parameter 'a\.k'"):
        cosim.write_ssp(system, tmp_path / "b.ssp")
    assert not (tmp_path / "b.ssp").exists()


def test_variants_are_listed_and_chosen_by_name_or_file(pack, tmp_path):
    other = structure(elements(component("b")), name="other")
    package = pack({**one(elements(component("a"))), "light.ssd": other})
    assert cosim.variants(package) == ["whole", "other"]
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


def test_a_system_may_lie_in_a_file_of_its_own_but_not_in_itself(pack, tmp_path):
    nested = '<ssd:Component name="n" type="application/x-ssp-definition" source="{}"/>'
    inner = structure(
        connectors(connector("i", "input")) + elements(component("a")) + connections(("i", "a.u"))
    ).replace("resources/", "")
    body = (
        connectors(connector("x", "input"))
        + elements(nested.format("resources/inner.ssd"))
        + connections(("x", "n.i"))
    )
    package = pack({**one(body), "resources/inner.ssd": inner})
    system, _ = cosim.read_ssp(package)
    assert system.inputs == {"x": ("n/a.u",)}
    assert end(system, "n/a.y", x=2.0) == 2.0
    system.set("n/a.k", 3.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert again.parameters == {"n/a.k": 3.0}
    system.add("n/b", system.components["n/a"])
    with pytest.raises(cosim.SspError, match="'n' lies in a file of its own"):
        cosim.write_ssp(system, tmp_path / "b.ssp")
    with pytest.raises(cosim.SspError, match="'n' contains itself"):
        cosim.read_ssp(pack(one(elements(nested.format("SystemStructure.ssd")))))


def test_versions_turn_into_each_other_where_they_can(pack, tmp_path):
    body = elements(component("a", connectors(connector("u", "input")), source="gain3.fmu"))
    two = one(body.replace("ssc:Real", "ssc:Float64"), version="2.0")
    system, _ = cosim.read_ssp(pack(two))
    old = cosim.write_ssp(system, tmp_path / "old.ssp", version="1.0")
    read_ssd(str(old))
    new = cosim.write_ssp(cosim.read_ssp(old)[0], tmp_path / "new.ssp", version="2.0")
    assert 'version="2.0"' in members_of(new)["SystemStructure.ssd"].decode()
    clock = body.replace("<ssc:Real/>", "<ssc:Clock/>")
    system, _ = cosim.read_ssp(pack(one(clock, version="2.0")))
    with pytest.raises(cosim.SspError, match=r"line 1: SSP 1\.0 cannot express this"):
        cosim.write_ssp(system, tmp_path / "old.ssp", version="1.0")


TWO = elements(component("a"), component("b"))
BOOLEAN = (
    '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/>'
    "</ssc:BooleanMappingTransformation>"
)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            TWO + connections(("a.y", "b.u", BOOLEAN)),
            r"BooleanMappingTransformation is for Boolean values, a\.y is of the type Real",
        ),
        (TWO + connections(("a.y", "b.y")), r"cannot connect a\.y to b\.y: both ends give"),
        (TWO + connections(("a.u", "b.u")), "both ends take"),
        (TWO + connections(("a.y", "b.u"), ("a.sum", "b.u")), r"b\.u is already connected"),
        (TWO + connections(("a.y", "b.k")), r"a\.y cannot feed b\.k: it is a parameter"),
        (TWO + connections(("a.y", "b.v")), "b has no connector 'v'"),
        (elements(component("a"), component("a")), "two elements 'a'"),
        (elements(component("a.b")), "a name without '.'"),
        (bind(("a.q", 1)) + TWO, "no variable 'q'"),
        (bind(("q.k", 1)) + TWO, r"no parameter 'q\.k'"),
        (elements(component("a", bind(("k", 1), ("y", 2)))), r"a\.y cannot be set"),
        (elements(component("a").replace(" source", ' type="text/x" source')), "'text/x'"),
        (
            connectors(connector("x", "input", "q")) + TWO + connections(("x", "a.u")),
            "'q' cannot be converted to 'N'",
        ),
        (
            elements('<ssd:SignalDictionaryReference name="r" dictionary="D"/>', component("a"))
            + connections(("a.y", "r.z")),
            "no signal dictionary 'D'",
        ),
        (
            DICTIONARY.replace('endConnector="force"', 'endConnector="farce"').replace(
                ' source="resources/d.ssb"/>',
                f">{ENTRIES.partition('?>')[2]}</ssd:SignalDictionary>",
            ),
            "no entry 'farce'; did you mean 'force'",
        ),
    ],
)
def test_what_cannot_be_is_refused_with_file_and_line(pack, body, message):
    with pytest.raises(
        cosim.SspError, match=rf"packed\.ssp: SystemStructure\.ssd, line 1: .*{message}"
    ):
        cosim.read_ssp(pack(one(body)))


def test_a_suppressed_conversion_is_not_done(pack):
    body = elements(component("a"), component("b", source="milli.fmu")) + connections(
        ("a.y", "b.u", line(7), ' suppressUnitConversion="true"')
    )
    system, _ = cosim.read_ssp(pack(one(body)))
    system.expose("x", "a.u")
    assert end(system, "b.y", x=2.0) == 14.0
    assert system.links != {"b.u": PLAIN}


def test_a_suppressed_conversion_joins_any_units(pack):
    """Number for number, as SSP has it: newtons become metres."""
    body = elements(component("a"), component("b", source="metres.fmu")) + connections(
        ("a.y", "b.u", "", ' suppressUnitConversion="true"')
    )
    system, _ = cosim.read_ssp(pack(one(body)))
    system.expose("x", "a.u")
    assert end(system, "b.y", x=2.0) == 2.0


def test_a_prefix_that_is_not_declared_is_no_xml(pack):
    text = structure(TWO).replace("<ssd:Units>", "<ssd:Units><osp:Algorithm/>")
    with pytest.raises(cosim.SspError, match=r"prefix osp.*not defined"):
        cosim.read_ssp(pack({"SystemStructure.ssd": text}))


def test_the_signals_of_a_written_package_are_those_of_the_system(make, tmp_path):
    system = cosim.System("units")
    system.add("a", make("gain", y="mN"), {"k": 2.0})
    system.add("b", make("integrator"))
    system.connect("a.y", "b.u")
    system.expose("x", "a.u")
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "a.ssp", version="2.0"))
    runs = [s.prepare(step=0.1, stop=1.0).run(inputs={"x": np.sin}) for s in (system, again)]
    np.testing.assert_array_equal(runs[0].values, runs[1].values)


TEMPERATURES = (
    '<ssd:Units><ssc:Unit name="K"><ssc:BaseUnit K="1"/></ssc:Unit><ssc:Unit name="degC">'
    '<ssc:BaseUnit K="1" offset="273.15"/></ssc:Unit><ssc:Unit name="degF"><ssc:BaseUnit K="1"'
    ' factor="0.5555555555555556" offset="255.3722222222222"/></ssc:Unit></ssd:Units>'
)


@pytest.mark.parametrize(
    ("kind", "of_20"),
    [(" difference", 20.0 * 5 / 9), ("", (20.0 - 32.0) * 5 / 9 + 273.15)],
    ids=["difference", "absolute"],
)
def test_units_of_ssp_are_for_differences_where_the_fmus_are(make, tmp_path, kind, of_20):
    """From degF through connectors in degC and degF into FMUs in degC and K; a parameter too."""
    inner = connectors(connector("in", "input", "degF"), connector("out", "output", "degF"))
    inner += elements(component("a", source="a.fmu")) + connections(("in", "a.u"), ("a.y", "out"))
    values = (
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet"
        ' version="1.0" name="p"><ssv:Parameters><ssv:Parameter name="k"><ssv:Real value="20"'
        ' unit="degF"/></ssv:Parameter></ssv:Parameters><ssv:Units><ssc:Unit name="degF">'
        '<ssc:BaseUnit K="1" factor="0.5555555555555556" offset="255.3722222222222"/></ssc:Unit>'
        "</ssv:Units></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding>"
        "</ssd:ParameterBindings>"
    )
    body = (
        connectors(connector("x", "input", "degF"))
        + elements(
            f'<ssd:System name="in">{inner}</ssd:System>',
            component("b", source="b.fmu"),
            component("p", values, source="p.fmu"),
        )
        + connections(("x", "in.in"), ("in.out", "b.u"))
    )
    path = tmp_path / "packed.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", structure(body, rest=TEMPERATURES))
        archive.write(make("gain", 2, u=f"degC{kind}", y=f"degC{kind}"), "resources/a.fmu")
        archive.write(make("gain", 3, u=f"K{kind}"), "resources/b.fmu")
        archive.write(make("gain", 3, k=f"K{kind}"), "resources/p.fmu")
    system, _ = cosim.read_ssp(path)
    assert end(system, "b.y", x=20.0) == pytest.approx(of_20, rel=1e-12)
    assert system.parameters["p.k"] == pytest.approx(of_20, rel=1e-12)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "again.ssp", version="1.0"))
    assert end(again, "b.y", x=20.0) == pytest.approx(of_20, rel=1e-12)
