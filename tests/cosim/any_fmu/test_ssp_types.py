"""Packages with signals that are no scalar numbers: enumerations, arrays."""

from functools import partial

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.ssp.markup import violation
from stickslip.cosim.ssp.structure import Package
from tests.corpus.fmu import archive
from tests.corpus.hostile import packages
from tests.cosim.single import joined, members

SPEED = (
    '<ssd:Enumerations><ssc:Enumeration name="Speed"><ssc:Item name="slow" value="1"/>'
    '<ssc:Item name="fast" value="2"/></ssc:Enumeration></ssd:Enumerations>'
)
connection = partial(packages.connection, convert=True)


@pytest.fixture
def pack(tmp_path):
    def pack(fmu, text):
        files = {"SystemStructure.ssd": text, "resources/a.fmu": fmu.read_bytes()}
        return archive(tmp_path / "packed.ssp", files)

    return pack


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


def bound(values, mapping=""):
    inside = f"<ssv:Parameters>{values}</ssv:Parameters>"
    held = packages.document("ssv:ParameterSet", inside, "2.0")
    content = f"<ssd:ParameterValues>{held}</ssd:ParameterValues>{mapping}"
    return packages.bound(f"<ssd:ParameterBinding>{content}</ssd:ParameterBinding>")


def parameter(name, kind, value, rest=""):
    return f'<ssv:Parameter name="{name}"><ssv:{kind} value="{value}" {rest}/></ssv:Parameter>'


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
    part = export("state_space", 3, "CS"), {"n": 2, "A": -np.eye(2)}
    system = joined(dict.fromkeys(names, part), f"{a}.y {b}.u", x=f"{a}.u[2]")
    system.set(f"{a}.x0", [1.0, 2.0])
    path = cosim.write_ssp(system, tmp_path / "a.ssp", version="2.0")
    assert is_valid(path)
    again, _ = cosim.read_ssp(path)
    assert (again.connections, again.inputs) == (system.connections, system.inputs)
    assert again.parameters == system.parameters
    assert b'size="2"' in members(path)["SystemStructure.ssd"]
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


MAP = (
    '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="3"/>'
    "</ssc:IntegerMappingTransformation>"
)
DOUBLE = '<ssc:LinearTransformation factor="2"/>'


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
            ("feedthrough", two(connection("a.Int8_out", "b.Int8_in", MAP))),
            "a IntegerMappingTransformation is not supported; map the values in a component",
        ),
        (
            ("feedthrough", two(connection("a.Boolean_out", "b.Boolean_in", DOUBLE))),
            r"for integer and number values, b\.Boolean_in is of the type Boolean",
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
