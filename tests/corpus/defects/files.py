"""Defects of the other files, and of the archive itself."""

import struct
from pathlib import Path
from typing import Any

from tests.corpus.defects.reference import (
    HERE,
    Members,
    Seed,
    Writer,
    binary_name,
    library,
    members,
    pack,
    replaced,
    with_files,
)
from tests.corpus.hostile.zips import DEFLATE, LINK, STORED, UTF8, Member, zipped

_TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
_BUILD = "sources/buildDescription.xml"


def _file_seeds(version: int) -> list[tuple[str, str, Writer]]:
    binary = binary_name(version)
    code = library()
    other = with_files({binary: None, binary_name(version).replace("reference", "other"): code})
    sources = {n: None for n in members(version) if n.startswith("sources/")}
    return [
        ("binary-missing", "named otherwise", other),
        ("not-a-library", "text", with_files({binary: b"this is text\n"})),
        ("not-a-library", "truncated", with_files({binary: code[:100]})),
        ("wrong-architecture", "of another processor", with_files({binary: _foreign(code)})),
        ("missing-function", "one not exported", with_files({binary: _renamed(code, version)})),
        ("unknown-platform", "folder amiga", with_files({"binaries/amiga/reference.so": code})),
        ("no-implementation", "nothing at all", with_files({binary: None} | sources)),
        ("not-run", "no binary", with_files({binary: None})),
        ("foreign-dependency", "needs a library", with_files({binary: _needing(code)})),
        ("does-not-load", "needs a library", with_files({binary: _needing(code)})),
        ("no-licence", "nowhere", _unlicensed),
        ("source-missing", "not packed", with_files({"sources/model.c": None})),
        ("bad-build-description", "schema", replaced(_BUILD, ("<SourceFile ", "<Source "))),
        ("bad-build-description", "not XML", with_files({_BUILD: b"<a>"})),
        ("bad-build-configuration", "unknown identifier", replaced(_BUILD, ("reference", "other"))),
        ("options-without-compiler", "options alone", replaced(_BUILD, ("<SourceFileSet ", '<SourceFileSet compilerOptions="-O2" '))),
        ("bad-terminals-file", "schema", replaced(_TERMINALS, ("matchingRule", "rule"))),
        ("misplaced-terminals", "in icons", with_files({_TERMINALS: None, "icons/terminalsAndIcons.xml": b"<a/>"})),
        ("terminal-of-unknown-variable", "y2", replaced(_TERMINALS, ('"y"', '"y2"'))),
        ("terminal-of-local-variable", "a state", replaced(_TERMINALS, ('"y"', '"x"'))),
        ("terminal-names", "member twice", replaced(_TERMINALS, ('memberName="x"', 'memberName="v"'))),
        ("terminal-names", "plug without names", replaced(_TERMINALS, ('memberName="x" ', ""))),
        ("icon-missing", "of a terminal", with_files({"terminalsAndIcons/port.png": None})),
        ("icon-missing", "of the FMU", with_files({"terminalsAndIcons/icon.png": None})),
        ("picture-is-no-png", "GIF", with_files({"terminalsAndIcons/icon.png": b"GIF89a"})),
        ("no-documentation", "none", with_files({"documentation/index.html": None})),
        ("licence-without-entry", "other name", with_files({"documentation/licenses/license.txt": None, "documentation/licenses/mit.txt": b"MIT"})),
        ("unexpected-file", "at the root", with_files({"readme.txt": b"hello"})),
    ]  # fmt: skip


def _unlicensed(path: Path, content: Members) -> None:
    description = content["modelDescription.xml"].replace(b'license="MIT" ', b"")
    kept = {n: d for n, d in content.items() if "/licenses/" not in n}
    pack(path, kept | {"modelDescription.xml": description})


def _foreign(code: bytes) -> bytes:
    """Return an ELF library with another machine in its header."""
    return code[:18] + struct.pack("<H", 0xF3) + code[20:]


def _renamed(code: bytes, version: int) -> bytes:
    """Return the library with one function under another name."""
    name = f"fmi{version}Terminate".encode() + b"\0"
    return code.replace(name, name.replace(b"Term", b"term"))


def _needing(code: bytes) -> bytes:
    """Return the library with the C library's name changed to that of nobody."""
    return code.replace(b"libc.so.6\0", b"libz.so.9\0")


_MANIFEST = {"extra/org.example/fmi-ls-manifest.xml": b"<fmiLayeredStandardManifest/>"}
_FILES3 = [
    ("bad-layered-standard", "attributes missing", with_files(_MANIFEST)),
    ("sources-without-build-description", "none", with_files({_BUILD: None})),
    ("headers-of-the-standard", "among the sources", with_files({"sources/fmi3Functions.h": b"/* */"})),
    ("extra-without-domain", "folder data", with_files({"extra/data/a.txt": b"a"})),
    ("bad-terminals-file", "other version", replaced(_TERMINALS, ('"3.0"', '"3.1"'))),
]  # fmt: skip


def _with_member(name: str, data: bytes = b"x", method: int = DEFLATE, **fields: Any) -> Writer:
    """Return a writer of a sound FMU with a further member, whose fields may lie."""

    def write(path: Path, content: Members) -> None:
        sound = [Member(n.encode(), d, DEFLATE) for n, d in content.items()]
        path.write_bytes(zipped([*sound, Member(name.encode(), data, method, **fields)]))

    return write


def _moved(name: str) -> Writer:
    description = (HERE / "description2.xml").read_bytes()
    return with_files({"modelDescription.xml": None, name: description})


_ARCHIVE = [
    ("not-a-zip", "text", lambda path, _: path.write_text("no FMU")),
    ("not-a-zip", "empty", lambda path, _: path.write_bytes(b"")),
    (
        "damaged-archive",
        "truncated",
        lambda path, _: path.write_bytes(zipped([Member(b"a", bytes(99))])[:60]),
    ),
    ("zip-bomb", "80 MB of zeros", _with_member("resources/zeros", bytes(80 * 1024**2))),
    ("unsafe-path", "goes up", _with_member("../../evil.txt")),
    ("unsafe-path", "absolute", _with_member("/etc/evil.txt")),
    ("unsafe-path", "drive", _with_member("C:/evil.txt")),
    ("unsafe-path", "backslash", _with_member("resources\\evil.txt")),
    ("duplicate-member", "description twice", _with_member("modelDescription.xml")),
    ("colliding-members", "case", _with_member("Sources/model.c")),
    ("colliding-members", "file and folder", _with_member("documentation/index.html/", b"")),
    ("unportable-path", "device", _with_member("resources/aux.txt")),
    ("unportable-path", "stream", _with_member("resources/a:b")),
    ("unportable-path", "dot at the end", _with_member("resources/a.")),
    ("unportable-path", "empty part", _with_member("resources//a")),
    ("unportable-path", "long", _with_member("resources/" + 200 * "a")),
    ("link-in-archive", "symbolic link", _with_member("resources/l", b"/", mode=LINK)),
    ("encrypted-member", "one", _with_member("resources/a", flags=1)),
    ("compression-method", "bzip2", _with_member("resources/a", method=12)),
    ("damaged-member", "another checksum", _with_member("resources/a", crc=1)),
    ("no-model-description", "in a folder", _moved("reference/modelDescription.xml")),
    ("no-model-description", "spelled otherwise", _moved("ModelDescription.xml")),
    ("foreign-letters", "an umlaut", _with_member("resources/ä.txt", flags=UTF8)),
]

SEEDS = [
    *(Seed("file", v, *seed) for v in (2, 3) for seed in _file_seeds(v)),
    *(Seed("file", 3, *seed) for seed in _FILES3),
    Seed("file", 2, "sources-not-listed", "none", lambda path, content: pack(path, {n: d for n, d in content.items() if n != _BUILD} | {"modelDescription.xml": content["modelDescription.xml"].replace(b'<SourceFiles>\n      <File name="model.c"/>\n    </SourceFiles>', b"")})),
    *(Seed("archive", 2, *seed) for seed in _ARCHIVE),
    Seed("archive", 3, "zip-version", "4.5", _with_member("resources/a", needs=45)),
    Seed("archive", 3, "stored-with-data-descriptor", "one", _with_member("resources/a", method=STORED, flags=8)),
]  # fmt: skip
