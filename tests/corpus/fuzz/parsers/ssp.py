"""The XML files of an .ssp package: SystemStructure.ssd and an .ssv, .ssm and .ssb beside it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from random import Random
from unittest import mock

from stickslip import cosim
from stickslip.cosim.ssp.markup import violation
from stickslip.cosim.ssp.package import Package
from stickslip.cosim.ssp.read import read_package
from tests.corpus.defects.reference import members, pack
from tests.corpus.fuzz.tokens import by_tokens
from tests.corpus.hostile.packages import (
    bound,
    component,
    connection,
    connector,
    document,
    structure,
)

EXPECTED = (cosim.CosimError,)
_BETWEEN = b"\n<!-- next file -->\n"
_FILES = ("SystemStructure.ssd", "resources/a.ssv", "resources/a.ssm", "resources/a.ssb")
_UNITS = (
    '<ssd:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit><ssc:Unit name="km/h">'
    '<ssc:BaseUnit m="1" s="-1" factor="0.2777777777777778"/></ssc:Unit></ssd:Units>'
)
_DICTIONARY = (
    '<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="resources/a.ssb"/>'
    "</ssd:SignalDictionaries>"
)
_BINDING = bound(
    '<ssd:ParameterBinding source="resources/a.ssv" prefix="a."><ssd:ParameterMapping'
    ' source="resources/a.ssm"/></ssd:ParameterBinding>'
    "<ssd:ParameterBinding><ssd:ParameterValues>"
    + document(
        "ssv:ParameterSet",
        '<ssv:Parameters><ssv:Parameter name="b.k"><ssv:Real value="3" unit="1/s"/></ssv:Parameter>'
        '<ssv:Parameter name="b.mode"><ssv:Integer value="2"/></ssv:Parameter></ssv:Parameters>',
    )
    + "</ssd:ParameterValues></ssd:ParameterBinding>"
)


def _structure(version: str) -> str:
    """Return two components, one of them in a system of its own, and a dictionary between them."""
    fmi, metres = (2 if version == "1.0" else 3), '<ssc:Real unit="m"/>'
    ends = connector("v", "input", '<ssc:Real unit="km/h"/>') + connector("x", "output", metres)
    of_a, of_d = (connector(*which, metres) for which in (("y", "output"), ("z", "inout")))
    inner = (
        f'<ssd:System name="inner"><ssd:Connectors>{ends}</ssd:Connectors><ssd:Elements>'
        f"{component('c', fmu=fmi)}</ssd:Elements><ssd:Connections>{connection('v', 'c.u')}"
        f"{connection('c.y', 'x')}</ssd:Connections></ssd:System>"
    )
    elements = (
        component("a", f"<ssd:Connectors>{of_a}</ssd:Connectors>", fmu=fmi)
        + component("b", fmu=fmi)
        + '<ssd:SignalDictionaryReference name="d" dictionary="bus"><ssd:Connectors>'
        + f"{of_d}</ssd:Connectors></ssd:SignalDictionaryReference>{inner}"
    )
    scaled = '<ssc:LinearTransformation factor="2" offset="-1"/>'
    ways = [("v", "a.u"), ("b.y", "d.z"), ("d.z", "inner.v"), ("inner.x", "x")]
    return structure(
        elements,
        [connection("a.y", "b.u", scaled), *(connection(*way) for way in ways)],
        connectors=ends,
        before=_BINDING,
        behind=_DICTIONARY,
        rest=_UNITS,
        version=version,
    )


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
        document("ssv:ParameterSet", values, version),
        document("ssm:ParameterMapping", mapping, version),
        document("ssb:SignalDictionary", entry, version),
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
        pack(folder / "resources" / f"{version}.fmu", members(version))


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
