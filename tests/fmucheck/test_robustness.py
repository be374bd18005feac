"""Nothing in a file makes the judge itself fail."""

import random

import pytest
from lxml import etree

from stickslip import fmucheck
from stickslip.fmucheck.description.model import number
from tests.corpus.defects.reference import members, pack

VALUES = ["", "-1", "0", "1e999", "NaN", "x y", "99999999999999999999", "true", "ä'\"", "exact"]


def scrambled(text: bytes, chance: random.Random) -> bytes:
    """Return the document with a few attributes and elements changed, moved or removed."""
    root = etree.fromstring(text)
    for _ in range(chance.randint(1, 6)):
        element = chance.choice([e for e in root.iter() if isinstance(e.tag, str)])
        kind = chance.randrange(5)
        if kind == 0 and element.attrib:
            element.set(chance.choice(sorted(element.attrib)), chance.choice(VALUES))
        elif kind == 1 and element.attrib:
            del element.attrib[chance.choice(sorted(element.attrib))]
        elif kind == 2 and element is not root:
            element.getparent().remove(element)
        elif kind == 3:
            element.tag = chance.choice(["Real", "Float64", "Clock", "Unknown", "Alias"])
        else:
            other = chance.choice(list(root))
            other.append(etree.fromstring(etree.tostring(element)))
    return etree.tostring(root)


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("version", [2, 3])
def test_any_description_is_judged(tmp_path, version, seed):
    content = members(version)
    text = scrambled(content["modelDescription.xml"], random.Random(f"{version} {seed}"))  # noqa: S311 (no secret)
    path = pack(tmp_path / "scrambled.fmu", content | {"modelDescription.xml": text})
    report = fmucheck.check(path, run=False)
    assert [f.severity for f in report] == sorted((f.severity for f in report), reverse=True)


@pytest.mark.parametrize("seed", range(40))
def test_any_bytes_are_judged(tmp_path, seed):
    """Bytes of a sound FMU changed at random places, its end cut off or not."""
    chance = random.Random(seed)  # noqa: S311 (no secret)
    data = bytearray(pack(tmp_path / "a.fmu", members(2)).read_bytes())
    for _ in range(chance.randint(1, 30)):
        data[chance.randrange(len(data))] = chance.randrange(256)
    path = tmp_path / "b.fmu"
    path.write_bytes(data[: chance.randint(1, len(data))] if seed % 2 else data)
    report = fmucheck.check(path, run=False)
    assert [f.severity for f in report] == sorted((f.severity for f in report), reverse=True)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"<a>" * 100_000,
        b'<!DOCTYPE a [<!ENTITY b "bbbbbbbbbb"><!ENTITY c "&b;&b;&b;&b;">]><a>&c;</a>',
        b'<fmiModelDescription fmiVersion="2.0" a="' + b"x" * 11_000_000 + b'"/>',
        '<?xml version="1.0" encoding="UTF-16"?><a/>'.encode("utf-16"),
    ],
    ids=["empty", "deep", "entities", "large attribute", "utf-16"],
)
def test_hostile_xml_is_an_error(tmp_path, text):
    path = pack(tmp_path / "hostile.fmu", {"modelDescription.xml": text})
    report = fmucheck.check(path)
    assert report.count(fmucheck.Severity.ERROR) > 0


def test_nothing_is_left_and_nothing_leaves_the_folder(tmp_path, monkeypatch):
    """Temporary files are gone whether the FMU is sound or its paths go up."""
    room = tmp_path / "room"
    room.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(room))
    outside = "terminalsAndIcons/../../../../../../../../etc/hostname"
    names = ("../../evil", "/tmp/fmucheck-evil", outside)  # noqa: S108 (not written)
    report = fmucheck.check(pack(tmp_path / "evil.fmu", members(2) | dict.fromkeys(names, b"")))
    assert {f.place for f in report if f.rule == "unsafe-path"} == {repr(name) for name in names}
    assert list(room.iterdir()) == []
    assert sorted(p.name for p in tmp_path.iterdir()) == ["evil.fmu", "room"]


def test_digits_without_end_are_no_number():
    """A pattern with two ways to divide them would be at it for hours."""
    assert number("9" * 1_000_000 + "x") is None
    assert number("9" * 300 + ".5e0") == float("9" * 300)
