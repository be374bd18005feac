"""modelDescription.xml, up to what a run needs of it."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random

from lxml import etree

from stickslip.fmi.description import DescriptionFault, read_description
from stickslip.fmi.xml import Malformed, parse_xml
from tests.corpus.defects.reference import HERE
from tests.corpus.fuzz.mutation import NUMBERS

EXPECTED = (Malformed, DescriptionFault)

_WORDS = (
    *("input", "output", "local", "parameter", "structuralParameter", "independent", "constant"),
    *("continuous", "discrete", "fixed", "tunable", "exact", "approx", "calculated", "true", "2.0"),
    *("3.0", "=cmd", "\u202e\u00e4'\"", "x" * 10_000, "../..", "con", "0 0 0", "1 2 3 4 5 6 7 8"),
    *(number.decode() for number in NUMBERS),
)
_ARRAY = b"""<fmiModelDescription fmiVersion="3.0" modelName="a" instantiationToken="a">
<CoSimulation modelIdentifier="a"/><ModelVariables>
<UInt64 name="n" valueReference="1" causality="structuralParameter" start="2"/>
<Clock name="c" valueReference="2" causality="input" intervalVariability="fixed" resolution="10"
 intervalCounter="1"/><Binary name="b" valueReference="3" causality="input"><Start value="00ff"/>
</Binary><Int32 name="m" valueReference="4" causality="parameter" start="1 2 3 4" min="0" max="9">
<Dimension valueReference="1"/><Dimension start="2"/></Int32></ModelVariables><ModelStructure/>
</fmiModelDescription>"""


def corpus() -> list[bytes]:
    sources = [(HERE / f"description{version}.xml").read_bytes() for version in (2, 3)]
    return [*(re.sub(rb">\s+<", b"><", source) for source in sources), _ARRAY]


def parse(data: bytes, folder: Path) -> None:  # noqa: ARG001 - nothing is written
    read_description(parse_xml(data))


def mutate(rng: Random, data: bytes) -> bytes:
    """Return it with some attributes, elements or texts changed, still well-formed."""
    root = etree.fromstring(data)
    for _ in range(rng.randint(1, 3)):
        elements = list(root.iter("*"))
        rng.choice(_CHANGES)(rng, rng.choice(elements), elements)
    return etree.tostring(root)


def _value(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    if element.attrib:
        key = rng.choice(element.keys())
        others = [other.get(key) for other in elements if key in other.attrib]
        element.set(key, rng.choice(rng.choice((_WORDS, others))))


def _attribute(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    donor = rng.choice(elements)
    if donor.attrib:
        key = rng.choice(donor.keys())
        element.set(key, donor.get(key))


def _drop(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    if element.attrib and rng.random() < 0.7:
        del element.attrib[rng.choice(element.keys())]
    elif element is not elements[0]:
        element.getparent().remove(element)


def _move(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    donor = etree.fromstring(etree.tostring(rng.choice(elements[1:] or elements)))
    element.insert(rng.randint(0, len(element)), donor)


def _rename(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    element.tag = rng.choice(elements).tag


_CHANGES = (_value, _value, _value, _value, _attribute, _drop, _move, _rename)
