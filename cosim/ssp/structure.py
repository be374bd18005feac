"""The elements of a system as SSP nests them, and the variants in an .ssp file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path as File
from typing import Any

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.connectors import Connector, Definitions, read_connectors, read_entries
from stickslip.cosim.ssp.markup import (
    FMU,
    NAMESPACES,
    NESTED,
    SEPARATOR,
    STRUCTURE,
    Path,
    attribute,
    check,
    component,
    find,
    inside,
    parse,
    place,
    tag,
)
from stickslip.cosim.system.system import Origin
from stickslip.fmi.archive import unpack
from stickslip.fmi.messages import suggestion

DEEPEST = 16
MOST_FILES = 1000
"""Nested systems in files of their own; each may be named many times, so a few can make many."""


@dataclass(frozen=True)
class Document:
    """An .ssd file of an unpacked package, ``top``; ``opened`` has all that were read with it."""

    file: File
    top: File
    root: Any
    definitions: Definitions
    opened: list[File] = field(default_factory=list)

    @classmethod
    def read(cls, file: File, top: File, opened: list[File] | None = None) -> Document:
        """Read a file of an unpacked package."""
        root = parse(file, "ssd")
        opened = [] if opened is None else opened
        opened.append(file)
        return cls(file, top, root, Definitions.of(root), opened)

    def locate(self, element: Any) -> File:
        """Return the file that the element's source names."""
        return inside(self.top, self.file.parent, element)


@dataclass
class Node:
    """An element as its parent mentions it, and its body: ssd:System of a system, else itself.

    Both may be of different documents. A reference names its ``dictionary``.
    """

    path: Path
    document: Document
    element: Any
    body: Any
    body_document: Document
    connectors: dict[str, Connector]
    fmu: File | None = None
    dictionary: str | None = None
    children: dict[str, Node] = field(default_factory=dict)
    dictionaries: dict[str, Mapping[str, Connector]] = field(default_factory=dict)

    def walk(self) -> Iterator[Node]:
        """Yield this element and all inside, parents first."""
        yield self
        for child in self.children.values():
            yield from child.walk()


def read_structure(file: File, top: File) -> Node:
    """Return the outermost system of an .ssd file."""
    document = Document.read(file, top)
    return _system((), find(document.root, "ssd:System"), document, (file,))


def _system(
    path: Path, body: Any, document: Document, files: tuple[File, ...], element: Any = None
) -> Node:
    connectors = read_connectors(body, document.definitions)
    node = Node(path, document, element, body, document, connectors)
    for entry in body.iterfind("ssd:SignalDictionaries/ssd:SignalDictionary", NAMESPACES):
        if (name := attribute(entry, "name")) in node.dictionaries:
            raise SspError(f"{place(entry)}: there are two signal dictionaries {name!r}")
        node.dictionaries[name] = _entries(entry, document)
    for child in body.iterfind("ssd:Elements/*", NAMESPACES):
        name = attribute(child, "name")
        if not name or "." in name or SEPARATOR in name:
            raise SspError(
                f"{place(child)}: element {name!r}: a name without '.' and '{SEPARATOR}' is needed,"
                f" because variables are called component.variable, outer{SEPARATOR}inner.variable"
            )
        if name in node.children:
            raise SspError(f"{place(child)}: there are two elements {name!r}")
        node.children[name] = _element((*path, name), child, document, files)
    return node


def _element(path: Path, element: Any, document: Document, files: tuple[File, ...]) -> Node:
    if element.tag == tag("ssd:System"):
        return _system(path, element, document, files, element)
    connectors = read_connectors(element, document.definitions)
    node = Node(path, document, element, element, document, connectors)
    if element.tag == tag("ssd:SignalDictionaryReference"):
        node.dictionary = attribute(element, "dictionary")
        return node
    kind = element.get("type", FMU)
    if kind in NESTED:
        return _nested(path, element, document, files)
    if kind != FMU:
        what = f"is of the type {kind!r}; only FMUs and SSP systems can be run"
        raise SspError(f"{place(element)}: component {component(path)!r} {what}")
    if element.get("source") is None:  # SSP 2.0 allows it
        what = "so there is nothing to run; give it an FMU"
        raise SspError(f"{place(element)}: component {component(path)!r} has no source, {what}")
    node.fmu = document.locate(element)
    return node


def _nested(path: Path, element: Any, document: Document, files: tuple[File, ...]) -> Node:
    file, top = document.locate(element), document.top
    if element.get("type") == NESTED[1]:
        try:
            top = unpacked(file)
        except SspError as fault:
            raise SspError(f"{place(element)}: {fault}") from fault
        file = top / STRUCTURE
    if file in files:
        raise SspError(f"{place(element)}: system {component(path)!r} contains itself")
    if len(files) > DEEPEST or len(document.opened) > MOST_FILES:
        what = f"more than {MOST_FILES} nested systems, or more than {DEEPEST} within each other"
        advice = "only so many are read"
        raise SspError(f"{place(element)}: system {component(path)!r}: {what}; {advice}")
    inner = Document.read(file, top, document.opened)
    node = _system(path, find(inner.root, "ssd:System"), inner, (*files, file), element)
    node.document = document
    return node


def unpacked(package: File) -> File:
    """Return the folder of an unpacked package, which has a description."""
    folder = unpack(package, "ssps", SspError)
    if not (folder / STRUCTURE).is_file():
        raise SspError(f"{package}: {STRUCTURE} is missing; this is not a system structure package")
    return folder


def _entries(element: Any, document: Document) -> dict[str, Connector]:
    if element.get("source"):
        root = parse(document.locate(element), "ssb")
    else:
        root = find(element, "ssb:SignalDictionary")
        check(root, "ssb")
    return read_entries(root, Definitions.of(root).within(document.definitions))


class Package(Origin):
    """An .ssp file that is unpacked, and the chosen variant."""

    @classmethod
    def open(cls, path: str | os.PathLike[str], variant: str | None = None) -> Package:
        """Unpack a file and choose a variant by the name it gives itself, or by its file."""
        whole = File(path).absolute()
        package = cls(whole, unpacked(whole))
        if variant is None:
            return package
        named = package.variants()
        files = {file: file for file in named.values()} | named
        if variant not in files:
            raise SspError(f"{whole}: no variant {variant!r}{suggestion(variant, files)}")
        return cls(whole, package.folder, files[variant])

    def variants(self) -> dict[str, str]:
        """Return name -> file of each variant, the default one first."""
        files = sorted(self.folder.glob("*.ssd"), key=lambda file: (file.name != STRUCTURE, file))
        names: dict[str, str] = {}
        for file in files:
            try:
                name = attribute(parse(file, "ssd"), "name")
            except SspError as fault:
                raise SspError(f"{self.path}: {fault}") from fault
            if name in names:
                what = f"are both called {name!r}; choose one by its file"
                raise SspError(f"{self.path}: {names[name]} and {file.name} {what}")
            names[name] = file.name
        return names


def variants(path: str | os.PathLike[str]) -> list[str]:
    """Return the names of the variants in an .ssp file, the default first, or raise SspError."""
    return list(Package.open(path).variants())
