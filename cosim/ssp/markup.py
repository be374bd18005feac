"""Names and namespaces of SSP 1.0 and 2.0, and its XML, whose errors name file and line."""

import math
import re
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path as File
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import etree

from stickslip.cosim.errors import SspError
from stickslip.fmi.description.units import BASE_UNITS, Unit
from stickslip.fmi.description.variables import Variable
from stickslip.fmi.files import read_limited
from stickslip.fmi.messages import printable, shown
from stickslip.fmi.xml import Malformed, parse_xml

_NAMES = {"ssd": "Description", "ssc": "Common", "ssv": "ParameterValues"}
_NAMES |= {"ssm": "ParameterMapping", "ssb": "SignalDictionary"}
_SSP1 = "http://ssp-standard.org/SSP1/SystemStructure"
NAMESPACES = {part: f"{_SSP1}{name}" for part, name in _NAMES.items()}
ROOTS = {"ssd": "ssd:SystemStructureDescription", "ssv": "ssv:ParameterSet"}
ROOTS |= {"ssm": "ssm:ParameterMapping", "ssb": "ssb:SignalDictionary"}
VERSIONS = ("1.0", "2.0")
STRUCTURE = "SystemStructure.ssd"
FMU = "application/x-fmu-sharedlibrary"
NESTED = ("application/x-ssp-definition", "application/x-ssp-package")

# SSP has no place for a step size. libcosim has this one, and reads it from here.
ANNOTATION = "com.opensimulationplatform"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"

# Between a nested system and its elements; a dot separates the variable.
SEPARATOR = "/"
Path = tuple[str, ...]
"""Names of elements, from the outermost system inwards; () is that system itself."""


def tag(name: str) -> str:
    """Return ``ssd:Name`` with its namespace, as lxml wants it."""
    prefix, _, local = name.partition(":")
    return f"{{{NAMESPACES[prefix]}}}{local}"


def component(path: Path) -> str:
    """Return the name of a component in a system without nesting: ``outer/inner``."""
    return SEPARATOR.join(path)


def path_of(name: str) -> Path:
    """Return where the component called ``outer/inner`` lies."""
    return tuple(name.split(SEPARATOR))


MOST_BYTES = 1 << 26
_SSP2 = ("pyssp_standard", "resources/ssp2")


def parse(file: File, part: str) -> Any:
    """Return the root of a file of a part (a key of `ROOTS`), valid as far as can be checked."""
    try:
        root = parse_xml(read_limited(file, MOST_BYTES), str(file), remarks=True)
    except OSError as fault:
        raise SspError(f"{file.name}: cannot be read: {fault.strerror}") from fault
    except Malformed as fault:
        raise SspError(f"{file.name}: {fault}{_remedy(str(fault))}") from fault
    check(root, part)
    return root


def check(root: Any, part: str) -> None:
    """Raise SspError unless an element is of a version that is known, and valid."""
    if root.tag != tag(ROOTS[part]):
        what = f"{tag(ROOTS[part])} (in SSP 1.0 and 2.0 alike); export it again for one of these"
        raise SspError(f"{place(root)}: the root element is {printable(root.tag)}, expected {what}")
    version = root.get("version", "")
    if version not in VERSIONS:
        raise SspError(f"{place(root)}: version is {shown(version)}, expected '1.0' or '2.0'")
    if fault := violation(root, part, version):
        newer = version == "1.0" and _schema(part, "2.0") and not violation(root, part, "2.0")
        hint = "; SSP 2.0 allows this: set version='2.0'" if newer else ""
        text = printable(short(fault[1]), 400).rstrip(".")
        raise SspError(f"{_file_name(root)}, line {fault[0]}: {text}{hint}")


def violation(root: Any, part: str, version: str) -> tuple[int, str] | None:
    """Return line and text of the first breach of the schema; None when the element is valid.

    FMPy has the schemas of SSP 1.0. Those of SSP 2.0 come with ``pyssp_standard``, an optional
    package: without it, files of that version are checked only for what is read of them.
    """
    schema = _schema(part, version)
    if schema is None or schema.validate(root):
        return None
    error = schema.error_log[0]
    return error.line, error.message


@cache
def _schema(part: str, version: str) -> Any:
    package, folder = ("fmpy", "ssp/schema") if version == "1.0" else _SSP2
    found = find_spec(package)
    if found is None or found.origin is None:
        return None
    file = File(found.origin).parent / folder / f"{NAMESPACES[part].rpartition('/')[2]}.xsd"
    return etree.XMLSchema(file=str(file)) if file.is_file() else None


def place(element: Any) -> str:
    """Return file and line of an element."""
    line = f", line {element.sourceline}" if element.sourceline else ""
    return f"{_file_name(element)}{line}"


def find(element: Any, path: str) -> Any:
    """Return the first element at a path such as ``ssd:System``, which must exist."""
    found = element.find(path, NAMESPACES)
    if found is None:
        raise SspError(f"{place(element)}: {path} is missing")
    return found


def attribute(element: Any, name: str) -> str:
    """Return an attribute, which must exist."""
    text: str | None = element.get(name)
    if text is None:
        raise SspError(f"{place(element)}: {local(element)} has no attribute {name!r}")
    return text


def number(element: Any, name: str, default: float) -> float:
    """Return an attribute as a finite number."""
    text = element.get(name)
    try:
        value = default if text is None else float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SspError(f"{place(element)}: {name} is {shown(text or '')}, expected a finite number")
    return value


def integer(text: str, element: Any) -> int:
    """Return an integer that an element holds as text."""
    try:
        return int(text)
    except ValueError:
        raise SspError(f"{place(element)}: {shown(text)} is not an integer") from None


def truth(element: Any, name: str) -> bool:
    """Return an attribute that is true or false, false where it is missing."""
    return element.get(name, "false").strip() in {"true", "1"}


def local(element: Any) -> str:
    """Return the name of an element without its namespace."""
    name: str = etree.QName(element).localname
    return name


def inside(top: File, base: File, element: Any) -> File:
    """Return the file below ``top`` that a source names by a URI relative to ``base``."""
    source = attribute(element, "source")
    try:
        uri = urlsplit(source)
        file = (base / unquote(uri.path)).resolve()
        found = file.is_file()
    except (OSError, ValueError):  # no name that a file can have
        raise SspError(f"{place(element)}: source {source[:99]!r} names no file") from None
    if uri.scheme or uri.netloc or not file.is_relative_to(top.resolve()):
        advice = "only its own files are read: copy it into resources/"
        raise SspError(f"{place(element)}: source {source!r} lies outside the package; {advice}")
    if not found:
        raise SspError(f"{place(element)}: source {source!r} is missing from the package")
    return file


def short(message: str) -> str:
    """Return a message with prefixes in place of the namespaces of SSP."""
    for prefix, namespace in NAMESPACES.items():
        message = message.replace(f"{{{namespace}}}", f"{prefix}:")
    return message


def _remedy(message: str) -> str:
    missing = re.search(r"Namespace prefix (\S+)", message)
    if not missing:
        return ""
    prefix = missing[1]
    uri = (NAMESPACES | {"osp": OSP}).get(prefix, "...")
    return f'; declare it at the root: xmlns:{prefix}="{uri}"'


def _file_name(element: Any) -> str:
    return File(unquote(element.getroottree().docinfo.URL or "XML")).name


# Order of the elements of a description, a system and a component in the schemas.
_ORDER = (
    "Connectors ElementGeometry ParameterBindings Elements Connections SignalDictionaries"
    " SystemGeometry GraphicalElements System Parameters Enumerations Units DefaultExperiment"
    " MetaData Signature Annotations"
)
_RANK = {name: rank for rank, name in enumerate(_ORDER.split())}
_FLOATS = {"Real", "Float64", "Float32"}
_OTHERS = {"Boolean", "String", "Enumeration", "Binary"}


def new_root(name: str, title: str, version: str) -> Any:
    """Return the root of a new file."""
    prefix = name.partition(":")[0]
    # libcosim takes a namespace declared on osp:Algorithm itself for an algorithm
    nsmap = {key: NAMESPACES[key] for key in (prefix, "ssc")} | {"osp": OSP}
    return etree.Element(tag(name), {"version": version, "name": title}, nsmap=nsmap)


def add(parent: Any, name: str, /, **attributes: str) -> Any:
    """Append an element."""
    return etree.SubElement(parent, tag(name), attributes)


def group(parent: Any, name: str) -> Any:
    """Return the child of this name, a new one in the order of the schemas if there is none."""
    found = parent.find(tag(name))
    if found is not None:
        return found
    new = etree.Element(tag(name))
    rank = _RANK[local(new)]
    behind = (c for c in parent.iterchildren("{*}*") if _RANK.get(local(c), 0) > rank)
    follower = next(behind, None)
    if follower is None:
        parent.append(new)
    else:
        follower.addprevious(new)
    return new


def add_connector(
    root: Any,
    element: Any,
    name: str,
    kind: str,
    variable: Variable,
    version: str,
    unit: Unit | None,
) -> None:
    """Give an element of a description a connector for a variable."""
    connector = add(group(element, "ssd:Connectors"), "ssd:Connector", name=name, kind=kind)
    type_name = type_of(variable, version)
    attributes = {}
    if type_name == "Enumeration":
        attributes["name"] = add_enumeration(root, variable)
    elif unit and unit.exponents and type_name in _FLOATS:
        attributes["unit"] = unit.name
    add(connector, f"ssc:{type_name}", **attributes)
    for length in variable.dimensions:
        add(connector, "ssc:Dimension", size=str(length))


def add_enumeration(root: Any, variable: Variable) -> str:
    """Define the enumeration of a variable that has no definition yet; return its name."""
    known = {
        enumeration.get("name"): [(item.get("name"), item.get("value")) for item in enumeration]
        for enumeration in root.iter(tag("ssc:Enumeration"))
        if len(enumeration)
    }
    wanted = [(name, str(value)) for name, value in variable.items]
    name = variable.enumeration or "Enumeration"
    while known.get(name, wanted) != wanted:
        name += "_"
    if name not in known:
        new = add(group(root, "ssd:Enumerations"), "ssc:Enumeration", name=name)
        for item, value in wanted:
            add(new, "ssc:Item", name=item, value=value)
    return name


def add_units(root: Any, name: str, units: Iterable[Unit]) -> None:
    """Define units that have no definition yet."""
    known = {unit.get("name") for unit in root.iter(tag("ssc:Unit"))}
    for unit in units:
        if unit.name in known or not unit.exponents:
            continue
        known.add(unit.name)
        base = add(add(group(root, name), "ssc:Unit", name=unit.name), "ssc:BaseUnit")
        for base_unit, exponent in zip(BASE_UNITS, unit.exponents, strict=True):
            if exponent:
                base.set(base_unit, str(exponent))
        if unit.factor != 1.0:
            base.set("factor", repr(unit.factor))
        if unit.offset != 0.0:
            base.set("offset", repr(unit.offset))


def type_of(variable: Variable, version: str) -> str:
    """Return the type of SSP for a variable: FMI 3.0 has its own in SSP 2.0 only."""
    if variable.type == "Enumeration" and not variable.items:
        return "Integer" if version == "1.0" else "Int64"
    if variable.type in _OTHERS or variable.type in {"Real", "Integer"} or version != "1.0":
        return variable.type
    return "Real" if variable.type in _FLOATS else "Integer"


def text_of(root: Any) -> bytes:
    """Return a file."""
    text: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return text


Members = dict[str, bytes]


def file_name(i: int, name: str) -> str:
    """Return a file name for a component."""
    return re.sub(r"[^\w-]", "_", f"{i}_{name}", flags=re.ASCII)


def free_name(stem: str, suffix: str, members: Members) -> str:
    """Return a member name that is not taken."""
    name, n = stem + suffix, 1
    while name in members:
        n += 1
        name = f"{stem}_{n}{suffix}"
    return name
