"""Systems that cannot be, and packages whose files attack or miss each other."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

from tests.corpus.hostile.case import Case
from tests.corpus.hostile.packages import (
    STRUCTURE,
    Text,
    binding,
    bound,
    component,
    connection,
    connector,
    document,
    experiment,
    packed,
    structure,
    system,
    values,
)

A, B = component("a"), component("b")
V = connector("v", "input")
LOOP = [connection("a.y", "b.u"), connection("b.y", "a.u")]
LAUGHS = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10 if i else "ha"}">' for i in range(12))


def _case(
    name: str,
    about: str,
    says: str,
    text: Text,
    members: Mapping[str, Text] | None = None,
    more: str = "",
) -> Case:
    files = {"system.ssp": packed(text, members)}
    return Case(21, f"ssp-{name}", about, says, f"simulate system.ssp {more}", files)


def _source(name: str, source: str, says: str) -> Case:
    text = structure(f'<ssd:Component name="a" source="{source}"/>')
    return _case(name, f"a component whose source is {source[:40]}", says, text)


def _bound(name: str, about: str, says: str, inside: str, **files: Text) -> Case:
    members = {file.replace("_", "."): text for file, text in files.items()}
    return _case(name, about, says, structure(A, before=inside), members)


def _connected(name: str, about: str, says: str, *connections: str, **how: str) -> Case:
    return _case(name, about, says, structure(A + B, connections, **how))


def _nested(source: str, kind: str = "definition") -> str:
    of = f'type="application/x-ssp-{kind}" source="{source}"'
    return structure(f'<ssd:Component name="n" {of}/>')


def _arrays(first: int, second: int) -> str:
    """Return an input that is an array, led to one of an inner system."""

    def ends(size: int) -> str:
        return connector("v", "input", f'<ssc:Float64/><ssc:Dimension size="{size}"/>')

    inner = system("i", A, connectors=ends(second))
    joined = [connection("v", "i.v")]
    return structure(inner, joined, connectors=ends(first), version="2.0")


def _grown(path: Path) -> None:
    """Let each of thirty files name the next one twice: a thousand million components."""
    with zipfile.ZipFile(path, "w") as archive:
        for k in range(31):
            element = (
                '<ssd:Component name="{}" type="application/x-ssp-definition" source="{}.ssd"/>'
            )
            inside = element.format("p", k + 1) + element.format("q", k + 1)
            text = structure(inside if k < 30 else A)
            archive.writestr(f"{k}.ssd" if k else STRUCTURE, text)


def _no_structure(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("README.txt", "nothing")


CONNECTIONS = [
    _case("cycle", "two components without delay and no common solution", r"the loop .* was not solved in \d+ iterations", structure(A + B, LOOP, before=binding("a.ssv")), {"a.ssv": values(("a.d", "1"), ("b.d", "1"))}),
    _connected("two-sources", "two outputs to one input", r"b\.u is already connected", connection("a.y", "b.u"), connection("a.z", "b.u")),
    _connected("two-outputs", "an output led to an output", "both ends give a signal", connection("a.y", "b.y")),
    _connected("unknown-element", "a connection to nowhere", "there is no component 'c'", connection("a.y", "c.u")),
    _connected("unknown-connector", "a connection to a variable that is none", "b has no connector 'w'", connection("a.y", "b.w")),
    _connected("types", "a text led to a number", "only types that lose nothing connect", connection("v", "b.u"), connectors=connector("v", "input", "<ssc:String/>")),
    _connected("units", "metres led to metres per second", "'m' cannot be converted to 'm/s'", connection("a.y", "b.u", convert=True)),
    _connected("unit-unknown", "furlongs led to metres per second", "'furlong' cannot be converted .*no file defines what 'furlong' is", connection("v", "b.u", convert=True), connectors=connector("v", "input", '<ssc:Real unit="furlong"/>')),
    _connected("scale-nan", "a transformation by NaN", "factor is 'NaN', expected a finite", connection("a.y", "b.u", '<ssc:LinearTransformation factor="NaN"/>')),
    _connected("mapping-of-numbers", "a table of integers between two numbers", "IntegerMapping.* is not supported", connection("a.y", "b.u", "<ssc:IntegerMappingTransformation><ssc:MapEntry" ' source="1" target="2"/></ssc:IntegerMappingTransformation>')),
    _case("arrays", "an array of three led to one of two", r"dimensions are \(3,\) and \(2,\)", _arrays(3, 2)),
    _case("array-huge", "an array of a thousand million elements", "at most 1000000", _arrays(10**9, 10**9)),
    _case("declared-otherwise", "a connector that its FMU has as something else", "a.y is declared as input", structure(component("a", f"<ssd:Connectors>{connector('y', 'input')}</ssd:Connectors>"), [connection("v", "a.y")], connectors=V)),
    _case("connector-twice", "two connectors of one name", "two connectors 'v'", structure(A, connectors=V + V)),
    _case("component-twice", "two components of one name", "two elements 'a'", structure(A + A)),
    _case("name-with-dot", "a component called a.b", "a name without '.'", structure(component("a.b"))),
    _case("no-dictionary-entry", "an entry that the dictionary has not", "no entry 'z'",
          structure(A + '<ssd:SignalDictionaryReference name="d" dictionary="bus"/>',
                    [connection("a.y", "d.z")],
                    behind='<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="a.ssb"/></ssd:SignalDictionaries>'),
          {"a.ssb": document("ssb:SignalDictionary", "")}),
    _case("circle", "two entries of a dictionary that are connected in a circle", "leads back to itself",
          structure(A + '<ssd:SignalDictionaryReference name="d" dictionary="bus"/>',
                    [connection("d.v", "d.w"), connection("d.w", "d.v")],
                    behind='<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="a.ssb"/></ssd:SignalDictionaries>'),
          {"a.ssb": document("ssb:SignalDictionary", "".join(f'<ssb:DictionaryEntry name="{e}"><ssc:Real/></ssb:DictionaryEntry>' for e in "vw"))}),
    _case("no-dictionary", "a reference to a signal dictionary that is none", "there is no signal dictionary 'bus'", structure(A + '<ssd:SignalDictionaryReference name="d" dictionary="bus"/>', [connection("a.y", "d.z")])),
]  # fmt: skip

SOURCES = [
    _source("traversal", "../../../etc/passwd", "lies outside the package"),
    _source("http", "http://127.0.0.1:9/a.fmu", "lies outside the package"),
    _source("source-missing", "resources/none.fmu", "is missing from the package"),
    _source("source-nul", "%00", "names no file"),
    _source("source-no-fmu", STRUCTURE, "not a zip archive"),
    _case("source-none", "a component without a source", "'a' has no source", structure('<ssd:Component name="a"/>', version="2.0")),
    _case("type-unknown", "a component that is a Modelica model", "only FMUs and SSP systems", structure('<ssd:Component name="a" type="text/x-modelica" source="resources/2.fmu"/>')),
    _case("contains-itself", "a nested system that is the outer one", "contains itself", _nested(STRUCTURE)),
    _case("ring", "two nested systems in each other", "contains itself", _nested("b.ssd"), {"b.ssd": _nested(STRUCTURE)}),
    _case("nested-no-package", "a nested package that is an FMU", "SystemStructure.ssd is missing", _nested("resources/2.fmu", "package")),
    Case(21, "ssp-nested-growth", "files that name the next one twice, thirty of them", "more than 1000 nested systems", "simulate a.ssp", {"a.ssp": _grown}),
    Case(21, "ssp-no-structure", "a package without SystemStructure.ssd", "SystemStructure.ssd is missing", "simulate a.ssp", {"a.ssp": _no_structure}),
    Case(21, "ssp-structure-alone", "a description that is not packed", "not a zip archive", "simulate a.ssp", {"a.ssp": structure(A)}),
]  # fmt: skip

MAPPING = document("ssm:ParameterMapping", '<ssm:MappingEntry source="none" target="a.k"/>')
BINDINGS = [
    _bound("values-missing", "a binding to an .ssv file that is not there", "'a.ssv' is missing", binding("a.ssv")),
    _bound("values-text", "an .ssv file that is text", "a.ssv: .*expected", binding("a.ssv"), a_ssv="k = 3"),
    _bound("values-of-another-kind", "an .ssv file that is a description", "root element is", binding(STRUCTURE)),
    _bound("value-no-number", "a parameter set to 1,5", "a.ssv, line 1: .*1,5", binding("a.ssv"), a_ssv=values(("a.k", "1,5"))),
    _bound("value-of-output", "a start value for an output", "a.y", binding("a.ssv"), a_ssv=values(("a.y", "1"))),
    _bound("value-of-nothing", "a start value for a component that is not there", "no parameter 'q.k'", binding("a.ssv"), a_ssv=values(("q.k", "1"))),
    _bound("value-beyond-maximum", "a start value above its maximum", "a.k .*10", binding("a.ssv"), a_ssv=values(("a.k", "11"))),
    _bound("value-of-another-unit", "a rate given in metres", "cannot be converted", binding("a.ssv"), a_ssv=values(("a.k", '1" unit="m'))),
    _bound("value-twice", "a start value of 1 and of 2 in one file", "'a.k' has two values in one set", binding("a.ssv"), a_ssv=values(("a.k", "1"), ("a.k", "2"))),
    _bound("mapping-two-sources", "two values mapped to one parameter", "target 'a.k' has two sources", binding("a.ssv", "a.ssm"), a_ssv=values(("x", "1"), ("y", "2")), a_ssm=document("ssm:ParameterMapping", '<ssm:MappingEntry source="x" target="a.k"/><ssm:MappingEntry source="y" target="a.k"/>')),
    _bound("mapping-no-target", "an empty target of a mapping", "a.ssm, line 1: no parameter ''", binding("a.ssv", "a.ssm"), a_ssv=values(("a.k", "1")), a_ssm=document("ssm:ParameterMapping", '<ssm:MappingEntry source="a.k" target=""/>')),
    _bound("mapping-no-source", "an empty source of a mapping beside one for a parameter that is none", "has no variable 'q'", binding("a.ssv", "a.ssm"), a_ssv=values(("a.k", "1")), a_ssm=document("ssm:ParameterMapping", '<ssm:MappingEntry source="" target="a.k"/><ssm:MappingEntry source="a.k" target="a.q"/>')),
    _bound("mapping-nan", "a mapping by NaN", "factor is 'NaN', expected a finite number", binding("a.ssv", "a.ssm"), a_ssv=values(("x", "1")), a_ssm=document("ssm:ParameterMapping", '<ssm:MappingEntry source="x" target="a.k"><ssc:LinearTransformation factor="NaN"/></ssm:MappingEntry>')),
    _bound("value-vector", "three numbers for one, in SSP 2.0", "a.k: expected a value of type Real, got", binding("a.ssv"), a_ssv=document("ssv:ParameterSet", '<ssv:Parameters><ssv:Parameter name="a.k"><ssv:Float64 value="1 2 3"/></ssv:Parameter></ssv:Parameters>', "2.0")),
    _bound("mapping-of-nothing", "a mapping of a parameter that is none", "no parameter 'none'", binding("a.ssv", "a.ssm"), a_ssv=values(("a.k", "1")), a_ssm=MAPPING),
    _case("dictionary-missing", "a signal dictionary in a file that is not there", "'a.ssb' is missing", structure(A, behind='<ssd:SignalDictionaries><ssd:SignalDictionary name="d"' ' source="a.ssb"/></ssd:SignalDictionaries>')),
    _case("binding-empty", "a binding that neither holds nor names values", "is missing", structure(A, before=bound("<ssd:ParameterBinding/>"))),
]  # fmt: skip

DEEP = "<a>" * 100_000
FILES = [
    _case("undeclared-prefix", "osp:Algorithm without a namespace", "declare it at the root", structure(A, times=experiment(declared=""))),
    _case("version-2-in-1", "a connector of SSP 2.0 in a file of 1.0", "set version='2.0'", structure(A, connectors=connector("v", "input", "<ssc:Float64/>"))),
    _case("version-unknown", "version 3.1", "version is '3.1'", structure(A, version="3.1")),
    _case("namespace-unknown", "the namespace SSP2", "in SSP 1.0 and 2.0 alike", structure(A).replace("/SSP1/", "/SSP2/")),
    _case("laughs", "a DOCTYPE of growing entities", "a DOCTYPE", f"<!DOCTYPE a [{LAUGHS}]>" + structure(A)),
    _case("deep", "elements a hundred thousand deep", "SystemStructure.ssd: .*[Dd]ep", DEEP),
    _case("empty-structure", "an empty description", "SystemStructure.ssd: ", ""),
    _case("units-twice-nothing", "a unit whose factor is 0", "factor of a unit cannot be 0", structure(A, rest='<ssd:Units><ssc:Unit name="m"><ssc:BaseUnit factor="0"/></ssc:Unit>' "</ssd:Units>")),
    _case("unit-two-definitions", "a unit that is a length and a time", "unit 'm' has two definitions", structure(A, rest='<ssd:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit><ssc:Unit' ' name="m"><ssc:BaseUnit s="1"/></ssc:Unit></ssd:Units>')),
    _case("dictionary-twice", "two signal dictionaries of one name", "two signal dictionaries 'd'", structure(A, behind="<ssd:SignalDictionaries>" + '<ssd:SignalDictionary name="d" source="a.ssb"/>' * 2 + "</ssd:SignalDictionaries>"), {"a.ssb": document("ssb:SignalDictionary", "")}),
    _case("real-to-enumeration", "a number led to an enumeration", "only types that lose nothing connect", structure(A + B, [connection("a.y", "b.mode")])),
    _case("binary-to-number", "binary data led to a number, in SSP 2.0", "only types that lose nothing connect", structure(A, [connection("v", "a.u")], connectors=connector("v", "input", "<ssc:Binary/>"), version="2.0")),
    _case("dictionary-two-sources", "two outputs led to one entry of a dictionary", "is already connected",
          structure(A + B + '<ssd:SignalDictionaryReference name="d" dictionary="bus"/>',
                    [connection("a.y", "d.z"), connection("b.y", "d.z")],
                    behind='<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="a.ssb"/></ssd:SignalDictionaries>'),
          {"a.ssb": document("ssb:SignalDictionary", '<ssb:DictionaryEntry name="z"><ssc:Real/></ssb:DictionaryEntry>')}),
    _case("no-stop", "no stopTime", "no stop time is proposed; give one in s: --stop S", structure(A, times=experiment(times='startTime="0"'))),
    _case("stop-before-start", "stopTime before startTime", "expected a time after", structure(A, times=experiment(times='startTime="5" stopTime="1"'))),
    _case("step-does-not-divide", "a step of 0.3 s in 1 s", "does not divide", structure(A, times=experiment("0.3"))),
    _case("step-zero", "a step of 0", "expected a positive one", structure(A, times=experiment("0"))),
    _case("variant-unknown", "a variant that the package has not", "no variant 'x'", structure(A), None, "--variant x"),
    _case("packed-input", "a packed input whose time falls", "line 3: time falls from 1.0 to 0.5", structure(A, [connection("v", "a.u")], connectors=V), {"extra/stickslip/input.csv": "time,v\n1,0\n0.5,1\n"}),
]  # fmt: skip

CASES = [*CONNECTIONS, *SOURCES, *BINDINGS, *FILES]
