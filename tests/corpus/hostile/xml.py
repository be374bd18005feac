"""Descriptions as files, and XML that attacks whoever reads it."""

from collections.abc import Callable

from tests.corpus.hostile.case import Case
from tests.corpus.hostile.sound import DESCRIPTION, describe, fmu, members, replaced
from tests.corpus.hostile.zips import Member, zipped

_HEAD = '<?xml version="1.0" encoding="UTF-8"?>'
_SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_LAUGHS = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10 if i else "ha"}">' for i in range(30))


def _xml(group: int, name: str, about: str, says: str, xml: Callable[[], bytes]) -> Case:
    """Return a case of an FMU with another description."""
    return fmu(group, name, about, says, lambda: zipped(describe(xml())))


def _dtd(name: str, about: str, dtd: str, use: str = "&e;") -> Case:
    def xml() -> bytes:
        pairs = (_HEAD, f"{_HEAD}<!DOCTYPE fmiModelDescription {dtd}>"), ("x' = -k x + u", use)
        return replaced(2, *pairs)

    return _xml(6, name, about, "a DOCTYPE", xml)


def _packed(name: str, about: str, says: str, members_: Callable[[], list[Member]]) -> Case:
    return fmu(5, name, about, says, lambda: zipped(members_()))


def _elsewhere(name: str) -> list[Member]:
    (content,) = (m for m in members() if m.name == DESCRIPTION.encode())
    return [Member(name.encode(), content.data), *members(2, [DESCRIPTION])]


def _system(name: str, about: str, says: str, ssd: str, command: str = "simulate a.ssp") -> Case:
    """Return a case of a package with this structure."""
    data = zipped([Member(b"SystemStructure.ssd", ssd.encode())])
    return Case(6, name, about, says, command, {"a.ssp": data})


_ROOT = f'<s:SystemStructureDescription xmlns:s="{_SSD}" version="1.0" name="a">'

_FILES = [
    _packed("missing", "no description", "is missing; this is not an FMU", lambda: members(2, [DESCRIPTION])),
    _packed("wrong-case", "ModelDescription.xml", "there is 'ModelDescription.xml'", lambda: _elsewhere("ModelDescription.xml")),
    _packed("in-a-folder", "packed with its folder", "there is 'model/modelDesc", lambda: _elsewhere(f"model/{DESCRIPTION}")),
    _packed("two", "two descriptions", "occurs twice", lambda: [*members(), Member(DESCRIPTION.encode(), b"<other/>")]),
    _packed("is-a-folder", "the description is a folder", "irectory|missing", lambda: [Member(b"modelDescription.xml/"), *members(2, [DESCRIPTION])]),
    _xml(5, "not-utf-8", "bytes that are no text", "line", lambda: replaced(2).replace(b"Input", b"\xff\xfe")),
    _xml(5, "nothing", "a description of 0 bytes", r"modelDescription\.xml: ", bytes),
    _xml(5, "no-xml", "a picture", r"modelDescription\.xml: ", lambda: b"\x89PNG\r\n\x1a\n"),
    _xml(5, "prefix", "a prefix that is not declared", "prefix", lambda: replaced(2, ("<LogCategories>", "<osp:a/><LogCategories>"))),
    _xml(5, "other-root", "a web page", "root element is 'html'", lambda: b"<html/>"),
    _xml(5, "no-variables", "no list of variables", "index of Unknown is 4, which is no variable", lambda: replaced(2).replace(b"ModelVariables", b"Variables")),
    _xml(5, "no-interface", "nothing that can be run", "no Co-Simulation", lambda: replaced(2).replace(b"CoSimulation", b"A").replace(b"ModelExchange", b"B")),
]  # fmt: skip

_ATTACKS = [
    _dtd("file-entity", "an entity that is a file", '[<!ENTITY e SYSTEM "file:///etc/passwd">]'),
    _dtd("web-dtd", "a DTD from the web", 'SYSTEM "http://example.org/a.dtd"', "a"),
    _dtd("laughs", "entities in entities: 10^29 of them", f"[{_LAUGHS}]", "&l29;"),
    _dtd("defaults", "attributes by DTD", '[<!ATTLIST Real start CDATA "666">]', "a"),
    _xml(6, "entity", "an entity that is not defined", "Entity", lambda: replaced(2, ("x' =", "&e;"))),
    _xml(6, "deep-elements", "200,000 elements deep", "depth", lambda: replaced(2, ("<LogCategories>", "<a>" * 200_000 + "<LogCategories>"))),
    _xml(6, "attribute", "an attribute of 12 MB", "exceeded|too long", lambda: replaced(2, ("Input", "a" * 12_000_000))),
    _xml(6, "attributes", "an attribute twice", "redefined", lambda: replaced(2, ('name="u"', 'name="u" name="u"'))),
    _xml(6, "second-root", "a second root", "line", lambda: replaced(2) + b"<a/>"),
    _xml(6, "hidden", "a DOCTYPE behind a comment", "a DOCTYPE", lambda: replaced(2, (_HEAD, f"{_HEAD} <!-- > --> <?a ?> <!DOCTYPE a>"))),
    _system("system-entity", "an entity that is a file, in a system", r"SystemStructure\.ssd: a DOCTYPE", f'<!DOCTYPE a [<!ENTITY e SYSTEM "file:///etc/passwd">]>{_ROOT}&e;</s:SystemStructureDescription>'),
    _system("system-laughs", "entities in entities, in a system", "a DOCTYPE", f"<!DOCTYPE a [{_LAUGHS}]>{_ROOT}&l29;</s:SystemStructureDescription>", "export a.ssp --as fmu"),
    _system("system-deep", "100,000 systems in one another", "depth", _ROOT + "<s:System>" * 100_000),
]  # fmt: skip

TOLERATED = [
    _xml(5, "utf-16", "text in UTF-16", "in UTF-16, expected UTF-8", lambda: replaced(2).decode().replace("UTF-8", "UTF-16").encode("utf-16")),
    _xml(5, "latin-1", "text in ISO-8859-1", "in ISO-8859-1, expected UTF-8", lambda: replaced(2, ("UTF-8", "ISO-8859-1"), ("Input", "\u00e4")).decode().encode("latin-1")),
]  # fmt: skip
"""Cases of which no run needs what is wrong: a warning says so, and they run."""

CASES = [*_FILES, *_ATTACKS]
