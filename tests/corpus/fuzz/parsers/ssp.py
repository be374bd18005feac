"""The XML files of an .ssp package: SystemStructure.ssd and an .ssv, .ssm and .ssb beside it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from random import Random
from unittest import mock

from stickslip import cosim
from stickslip.cosim.ssp.package import Package
from stickslip.cosim.ssp.read import read_package
from stickslip.cosim.ssp.schema import violation
from tests.corpus.defects.reference import members, pack
from tests.corpus.fuzz.tokens import by_tokens

EXPECTED = (cosim.CosimError,)
_BETWEEN = b"\n<!-- next file -->\n"
_FILES = ("SystemStructure.ssd", "resources/a.ssv", "resources/a.ssm", "resources/a.ssb")
_ROOT = "http://ssp-standard.org/SSP1/SystemStructure"
_NAMES = {
    "ssd": "Description",
    "ssc": "Common",
    "ssv": "ParameterValues",
    "ssm": "ParameterMapping",
    "ssb": "SignalDictionary",
}
_DECLARED = " ".join(f'xmlns:{p}="{_ROOT}{name}"' for p, name in _NAMES.items())


def _document(root: str, inside: str, version: str = "1.0") -> str:
    name = "" if root in {"ssm:ParameterMapping", "ssb:SignalDictionary"} else ' name="n"'
    return f'<{root} {_DECLARED} version="{version}"{name}>{inside}</{root}>'


_UNITS = (
    '<ssd:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit><ssc:Unit name="km/h">'
    '<ssc:BaseUnit m="1" s="-1" factor="0.2777777777777778"/></ssc:Unit></ssd:Units>'
)
_BINDING = (
    "<ssd:ParameterBindings>"
    '<ssd:ParameterBinding source="resources/a.ssv" prefix="a."><ssd:ParameterMapping'
    ' source="resources/a.ssm"/></ssd:ParameterBinding>'
    "<ssd:ParameterBinding><ssd:ParameterValues>"
    + _document(
        "ssv:ParameterSet",
        '<ssv:Parameters><ssv:Parameter name="b.k"><ssv:Real value="3" unit="1/s"/></ssv:Parameter>'
        '<ssv:Parameter name="b.mode"><ssv:Integer value="2"/></ssv:Parameter></ssv:Parameters>',
    )
    + "</ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
)
_EXPERIMENT = (
    '<ssd:DefaultExperiment startTime="0" stopTime="1"><ssd:Annotations><ssc:Annotation'
    ' type="com.opensimulationplatform"><osp:Algorithm'
    ' xmlns:osp="http://opensimulationplatform.com/SSP/OSPAnnotations"><osp:FixedStepAlgorithm'
    ' baseStepSize="0.1"/></osp:Algorithm></ssc:Annotation></ssd:Annotations>'
    "</ssd:DefaultExperiment>"
)


def _connector(name: str, kind: str, kind_of_value: str = '<ssc:Real unit="m"/>') -> str:
    return f'<ssd:Connector name="{name}" kind="{kind}">{kind_of_value}</ssd:Connector>'


def _connection(start: str, end: str, inside: str = "") -> str:
    parts = (which.rpartition(".") for which in (start, end))
    (a, _, y), (b, _, u) = parts
    left = f'startElement="{a}" ' * bool(a) + f'startConnector="{y}"'
    right = f'endElement="{b}" ' * bool(b) + f'endConnector="{u}"'
    return f'<ssd:Connection {left} {right} suppressUnitConversion="true">{inside}</ssd:Connection>'


def _structure(version: str) -> str:
    source = f"resources/{'fmi2' if version == '1.0' else 'fmi3'}.fmu"
    fmu = f'<ssd:Component name="{{}}" source="{source}">{{}}</ssd:Component>'
    ends = _connector("v", "input", '<ssc:Real unit="km/h"/>') + _connector("x", "output")
    dictionary = (
        '<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="resources/a.ssb"/>'
        "</ssd:SignalDictionaries>"
    )
    inner = (
        f'<ssd:System name="inner"><ssd:Connectors>{ends}</ssd:Connectors><ssd:Elements>'
        f"{fmu.format('c', '')}</ssd:Elements><ssd:Connections>{_connection('v', 'c.u')}"
        f"{_connection('c.y', 'x')}</ssd:Connections></ssd:System>"
    )
    elements = (
        fmu.format("a", f"<ssd:Connectors>{_connector('y', 'output')}</ssd:Connectors>")
        + fmu.format("b", "")
        + '<ssd:SignalDictionaryReference name="d" dictionary="bus"><ssd:Connectors>'
        + _connector("z", "inout")
        + "</ssd:Connectors></ssd:SignalDictionaryReference>"
        + inner
    )
    scaled = '<ssc:LinearTransformation factor="2" offset="-1"/>'
    connections = (
        _connection("a.y", "b.u", scaled)
        + _connection("v", "a.u")
        + _connection("b.y", "d.z")
        + _connection("d.z", "inner.v")
        + _connection("inner.x", "x")
    )
    system = (
        f'<ssd:System name="s"><ssd:Connectors>{ends}</ssd:Connectors>{_BINDING}<ssd:Elements>'
        f"{elements}</ssd:Elements><ssd:Connections>{connections}</ssd:Connections>{dictionary}"
        "</ssd:System>"
    )
    return _document("ssd:SystemStructureDescription", system + _UNITS + _EXPERIMENT, version)


def _beside(version: str) -> tuple[str, str, str]:
    values = (
        '<ssv:Parameters><ssv:Parameter name="k"><ssv:Real value="1.5" unit="1/s"/></ssv:Parameter>'
        '<ssv:Parameter name="x0"><ssv:Real value="2"/></ssv:Parameter></ssv:Parameters>'
    )
    mapping = (
        '<ssm:MappingEntry source="a.k" target="a.k"><ssc:LinearTransformation factor="2"/>'
        '</ssm:MappingEntry><ssm:MappingEntry source="a.x0" target="b.d"/>'
    )
    entry = '<ssb:DictionaryEntry name="z"><ssc:Real unit="m"/></ssb:DictionaryEntry>'
    return (
        _document("ssv:ParameterSet", values, version),
        _document("ssm:ParameterMapping", mapping, version),
        _document("ssb:SignalDictionary", entry, version),
    )


_TEXTS = (_structure("2.0") + "".join(_beside("1.0"))).encode()
_WORDS = (
    *sorted(set(re.findall(rb"[\w:.]+", _TEXTS))),
    *(b"<", b"/>", b"</", b'"', b"&lt;", b"&a;", b"<!--", b"]]>", b"<![CDATA[", b"<?a?>"),
    *(b'<!DOCTYPE a [<!ENTITY a "b">]>', b"x[1]", b"w[2]", b"w", b"Boolean", b"Enumeration"),
    *(b"String", b"Float64", b"Int32", b"parameter", b"calculatedParameter", b"../a.fmu"),
    *(b"ssc:Dimension", b"ssc:IntegerMappingTransformation", b"ssc:MapEntry", b"mode", b"count"),
)


def corpus() -> list[bytes]:
    texts = ((_structure(version), *_beside(version)) for version in ("1.0", "2.0"))
    return [_BETWEEN.join(text.encode() for text in files) for files in texts]


@cache
def _fmus(folder: Path) -> None:
    (folder / "resources").mkdir(exist_ok=True)
    for version in (2, 3):
        pack(folder / "resources" / f"fmi{version}.fmu", members(version))


_read = cache(cosim.Fmu)
_add = cosim.System.add


def _add_once(system: cosim.System, name: str, fmu: Path) -> None:
    """Add a component whose FMU is read but the first time."""
    _add(system, name, _read(fmu))


def parse(data: bytes, folder: Path) -> None:
    _fmus(folder)
    for name, text in zip(_FILES, data.split(_BETWEEN), strict=False):
        (folder / name).write_bytes(text)
    with mock.patch("stickslip.cosim.System.add", _add_once), mock.patch(*_schemas(data)):
        read_package(Package(folder, folder))


def _schemas(data: bytes) -> tuple[str, object]:
    """Let half of the inputs meet no schema, as where those of SSP 2.0 are not installed."""
    return "stickslip.cosim.ssp.markup.violation", violation if len(data) % 2 else lambda *_: None


def mutate(rng: Random, data: bytes) -> bytes:
    return by_tokens(rng, data, _WORDS)
