"""Packages with signals that are no scalar numbers: mapped values, enumerations, arrays."""

import zipfile
from functools import partial

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Link, ValueMap
from stickslip.cosim.ssp.markup import violation
from stickslip.cosim.ssp.structure import Package
from tests.corpus.hostile import packages

SPEED = (
    '<ssd:Enumerations><ssc:Enumeration name="Speed"><ssc:Item name="slow" value="1"/>'
    '<ssc:Item name="fast" value="2"/></ssc:Enumeration></ssd:Enumerations>'
)
connection = partial(packages.connection, convert=True)


@pytest.fixture
def pack(tmp_path):
    def pack(fmu, text):
        path = tmp_path / "packed.ssp"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("SystemStructure.ssd", text)
            archive.write(fmu, "resources/a.fmu")
        return path

    return pack


def pairs(kind, *pairs):
    entries = "".join(f'<ssc:MapEntry source="{x}" target="{y}"/>' for x, y in pairs)
    return f"<ssc:{kind}MappingTransformation>{entries}</ssc:{kind}MappingTransformation>"


def two(*connections, connectors="", of_a="", of_b=""):
    """Return a description of two components of one FMU."""
    elements = (packages.component(name, of, fmu="a") for name, of in (("a", of_a), ("b", of_b)))
    how = {"connectors": connectors, "rest": SPEED, "times": "", "version": "2.0"}
    return packages.structure("".join(elements), connections, **how)


def is_valid(path):
    package = Package.open(path)
    for file in [*package.folder.glob("*.ssd"), *package.folder.rglob("*.ssv")]:
        root = cosim.ssp.markup.parse(file, file.suffix[1:])
        if violation(root, file.suffix[1:], root.get("version")):
            return False
    return True


MAPPED = [
    ("Boolean", pairs("Boolean", ("true", "false"), ("0", "1")), {1: 0, 0: 1}),
    ("Int16", pairs("Integer", (1, 5), (7, 0)), {1: 5, 7: 0}),
    ("Enumeration", pairs("Integer", (1, 2)), {1: 2}),
    ("Enumeration", pairs("Enumeration", ("a", "b"), ("b", "a")), {1: 2, 2: 1}),
]


@pytest.mark.parametrize(("kind", "text", "expected"), MAPPED)
def test_mapped_connections_are_read_run_and_written(export, pack, tmp_path, kind, text, expected):
    body = two(connection(f"a.{kind}_out", f"b.{kind}_in", text))
    package = pack(export("feedthrough", 3), body)
    system, _ = cosim.read_ssp(package)
    assert system.links == {f"b.{kind}_in": Link(ValueMap.of(expected))}
    assert cosim.write_ssp(system, tmp_path / "same.ssp").stat().st_size
    system.expose("u", f"a.{kind}_in")
    result = system.prepare(step=0.1, stop=0.2).run(inputs={"u": np.array([0, 1, 1])})
    assert result[f"b.{kind}_out"][-1] == expected[1]
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert again.links == system.links


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_a_new_system_with_maps_is_written_and_read_back(export, tmp_path, version):
    system = cosim.System("maps")
    for name in ("a", "b"):
        system.add(name, export("feedthrough", 2 if version == "1.0" else 3))
    links = {"Boolean": {1: 0, 0: 1}, "Enumeration": {1: 2, 2: 1}, "Int32": {4: 5}}
    for kind, given in links.items():
        system.connect(f"a.{kind}_out", f"b.{kind}_in", Link(ValueMap.of(given)))
    system.expose("u", "a.Enumeration_in")
    system.expose_output("y", "b.Boolean_out")
    path = cosim.write_ssp(system, tmp_path / "a.ssp", version=version)
    again, _ = cosim.read_ssp(path)
    assert (again.links, again.connections) == (system.links, system.connections)
    assert (again.inputs, again.outputs) == (system.inputs, system.outputs)
    assert is_valid(path)
    text = zipfile.ZipFile(path).read("SystemStructure.ssd").decode()
    for kind in ("Boolean", "Enumeration", "Integer"):
        assert f"ssc:{kind}MappingTransformation" in text


def test_what_ssp_has_no_words_for_is_refused(export, tmp_path):
    system = cosim.System("maps")
    for name in ("a", "b"):
        system.add(name, export("feedthrough", 3))
    system.connect("a.Boolean_out", "b.Int8_in", Link(ValueMap.of({1: 5})))
    with pytest.raises(cosim.SspError, match=r"b\.Int8_in: SSP has no pairs of Boolean and Int8"):
        cosim.write_ssp(system, tmp_path / "a.ssp", version="2.0")


def bound(values, mapping=""):
    inside = f"<ssv:Parameters>{values}</ssv:Parameters>"
    held = packages.document("ssv:ParameterSet", inside, "2.0")
    content = f"<ssd:ParameterValues>{held}</ssd:ParameterValues>{mapping}"
    return packages.bound(f"<ssd:ParameterBinding>{content}</ssd:ParameterBinding>")


def parameter(name, kind, value, rest=""):
    return f'<ssv:Parameter name="{name}"><ssv:{kind} value="{value}" {rest}/></ssv:Parameter>'


def mapping(*entries):
    lines = "".join(
        f'<ssm:MappingEntry source="{source}" target="{target}">{text}</ssm:MappingEntry>'
        for source, target, text in entries
    )
    held = packages.document("ssm:ParameterMapping", lines, "2.0")
    return f"<ssd:ParameterMapping>{held}</ssd:ParameterMapping>"


def test_mapped_parameters_take_pairs_of_every_type(export, pack, tmp_path):
    values = (
        parameter("on", "Boolean", "true")
        + parameter("n", "Int32", 4)
        + parameter("m", "Int32", 9)
        + parameter("speed", "Enumeration", "fast", 'name="Speed"')
    )
    entries = mapping(
        ("on", "Boolean_in", pairs("Boolean", ("true", "false"))),
        ("n", "Int8_in", pairs("Integer", (4, 40))),
        ("m", "Int16_in", pairs("Integer", (4, 40))),  # has no pair and stays
        ("speed", "Enumeration_in", pairs("Enumeration", ("fast", "b"))),
        ("speed", "UInt8_in", pairs("Integer", (2, 200))),
    )
    body = two(of_a=bound(values, entries))
    system, _ = cosim.read_ssp(pack(export("feedthrough", 3), body))
    assert system.parameters == {
        "a.Boolean_in": False,
        "a.Int8_in": 40,
        "a.Int16_in": 9,
        "a.Enumeration_in": 2,
        "a.UInt8_in": 200,
    }
    system.set("a.Int8_in", 41)
    system.set("a.Boolean_in", True)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert again.parameters == system.parameters


def declared(name, kind, value="Float64"):
    """Return the connectors of a component."""
    inside = packages.connector(name, kind, f"<ssc:{value}/>")
    return f"<ssd:Connectors>{inside}</ssd:Connectors>"


def array(size=""):
    """Return a connector of the system that is an array."""
    return packages.connector("x", "input", f"<ssc:Float64/><ssc:Dimension{size}/>")


MATRIX = "-1 0 0 0 -2 0 0 0 -3"


def test_arrays_are_connected_as_a_whole_and_by_element(export, pack, tmp_path):
    values = parameter("A", "Float64", MATRIX) + parameter("x0", "Float64", "1 2 3")
    body = two(
        connection("x", "a.u"),
        connection("a.y", "b.u", startIndices="2", endIndices="3"),
        connection("a.y", "b.u", startIndices="3", endIndices="1"),
        connectors=array(),
        of_a=bound(values),
    )
    system, _ = cosim.read_ssp(pack(export("state_space", 3, "CS"), body))
    assert system.connections == {"b.u[3]": "a.y[2]", "b.u[1]": "a.y[3]"}
    assert system.inputs == {f"x[{i}]": (f"a.u[{i}]",) for i in (1, 2, 3)}
    assert system.parameters["a.x0"] == (1.0, 2.0, 3.0)
    del system.connections["b.u[3]"]
    system.connect("a.y[1]", "b.u[2]")
    system.set("b.A[1,2]", 5.0)
    again, _ = cosim.read_ssp(cosim.write_ssp(system, tmp_path / "b.ssp"))
    assert (again.connections, again.inputs) == (system.connections, system.inputs)
    assert again.parameters["b.A"] == (-1.0, 5.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)
    runs = [s.prepare(step=0.1, stop=1.0).run().values for s in (system, again)]
    np.testing.assert_array_equal(*runs)


@pytest.mark.parametrize("names", [("a", "b"), ("left/a", "right/b")])
def test_a_new_system_of_arrays_is_written_and_read_back(export, tmp_path, names):
    a, b = names
    system = cosim.System("arrays")
    for name in names:
        system.add(name, export("state_space", 3, "CS"), {"n": 2, "A": -np.eye(2)})
    system.set(f"{a}.x0", [1.0, 2.0])
    system.connect(f"{a}.y", f"{b}.u")
    system.expose("x", f"{a}.u[2]")
    path = cosim.write_ssp(system, tmp_path / "a.ssp", version="2.0")
    assert is_valid(path)
    again, _ = cosim.read_ssp(path)
    assert (again.connections, again.inputs) == (system.connections, system.inputs)
    assert again.parameters == system.parameters
    text = zipfile.ZipFile(path).read("SystemStructure.ssd").decode()
    assert 'size="2"' in text
    assert text.count("Indices") == 1  # of x; y goes to u as a whole
    del again.connections[f"{b}.u[1]"]  # one of a connection of both
    third, _ = cosim.read_ssp(cosim.write_ssp(again, tmp_path / "b.ssp"))
    assert third.connections == {f"{b}.u[2]": f"{a}.y[2]"}
    whole, _ = cosim.read_ssp(path)
    del whole.components[a]
    whole.parameters = {n: x for n, x in whole.parameters.items() if n.startswith(f"{b}.")}
    whole.connections, whole.inputs = {}, {}
    fourth, _ = cosim.read_ssp(cosim.write_ssp(whole, tmp_path / "c.ssp"))
    assert list(fourth.components) == [b]
    with pytest.raises(cosim.SspError, match=r"SSP 1\.0 has no values that are arrays"):
        cosim.write_ssp(system, tmp_path / "c.ssp", version="1.0")


def mapped(kind, text):
    return "feedthrough", two(connection(f"a.{kind}_out", f"b.{kind}_in", text))


def otherwise(*connector):
    of_b = declared("Float64_in", *connector)
    return "feedthrough", two(connection("a.Float64_out", "b.Float64_in"), of_b=of_b)


def elements(source, target, /, *more, size="", **indices):
    joined = connection(source, target, **{f"{which}Indices": i for which, i in indices.items()})
    return "state_space", two(joined, *more, connectors=array(size) if source == "x" else "")


@pytest.mark.parametrize(
    ("packed", "message"),
    [
        (
            mapped("Int8", pairs("Boolean", ("true", "false"))),
            r"BooleanMappingTransformation is for Boolean values, a\.Int8_out is of the type Int8",
        ),
        (
            mapped("Int8", pairs("Integer", (1, 300))),
            r"b\.Int8_in: expected a value of type Int8, got 300",
        ),
        (mapped("Int8", pairs("Integer", (1, 3), (1, 4))), "maps '1' twice"),
        (
            mapped("Enumeration", pairs("Enumeration", ("a", "bb"))),
            "'bb' is not a value of its type; did you mean 'b'",
        ),
        (
            otherwise("input", "String"),
            r"b\.Float64_in is declared as input String, its FMU has input Float64",
        ),
        (
            elements("a.y", "b.u", end="1"),
            r"cannot connect a\.y to b\.u\[1\]: their dimensions are \(3,\) and \(\)",
        ),
        (elements("a.y", "b.u", start="4", end="1"), r"no variable 'y\[4\]'"),
        (elements("a.y", "b.u", start="0", end="1"), "startIndices count from 1"),
        (
            elements("a.y", "b.u", connection("a.y", "b.u", startIndices="1", endIndices="2")),
            r"b\.u\[2\] is already connected",
        ),
        (
            elements("x", "a.u", size=' size="3"', start="5", end="1"),
            r"x\[5\] is not an element of an array of the dimensions \(3,\)",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_file_and_line(export, pack, packed, message):
    model, text = packed
    with pytest.raises(
        cosim.SspError, match=rf"packed\.ssp: SystemStructure\.ssd, line 1: .*{message}"
    ) as error:
        cosim.read_ssp(pack(export(model, 3, "CS"), text))
    assert "\n" not in str(error.value)
