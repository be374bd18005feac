"""FMUs for tests: a library compiled from C, and a description made from a table."""

import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from stickslip.fmi import toolchain

FMI2_TYPES = {
    "Float64": "Real",
    "Int32": "Integer",
    **{name: name for name in ("Boolean", "Enumeration", "String")},
}
TIME = 99
"""Value reference of the time in FMI 3.0."""

EXPORT = """#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
"""
"""C for what a library shows."""


@dataclass(frozen=True)
class Variable:
    """A row of a description."""

    name: str
    causality: str = "local"
    start: object = None  # as it is written
    type: str = "Float64"
    variability: str | None = None  # fixed for parameters, else continuous or discrete by the type
    initial: str | None = None
    reference: int | None = None  # the place in the table by default
    derivative: str | None = None  # name of its state
    depends: Sequence[str] | None = None  # names; None where this is not declared
    dimensions: Sequence[str] = ()  # attributes of each, in FMI 3.0
    attributes: str = ""  # further ones of the type
    inside: str = ""


def describe(
    name: str,
    version: int,
    variables: Iterable[Variable],
    interfaces: Mapping[str, str],
    *,
    token: str | None = None,  # the name by default
    head: str = "",  # further attributes of the root
    types: str = "",  # elements between the interfaces and the default experiment
    experiment: str = "",  # its attributes
    structure: str = "",  # further elements of it in FMI 3.0
) -> str:
    """Return modelDescription.xml; variables of types that FMI 2.0 lacks are left out in it."""
    table = [
        (v.reference if v.reference is not None else place, v)
        for place, v in enumerate(v for v in variables if version == 3 or v.type in FMI2_TYPES)
    ]
    # what the structure and derivatives name a variable by
    place = {v.name: i if version == 2 else r for i, (r, v) in enumerate(table, 1)}
    texts = [_variable(r, v, version, place) for r, v in table]
    unknowns: dict[str, list[str]] = {"Output": [], "ContinuousStateDerivative": []}
    key = "index" if version == 2 else "valueReference"
    for _, v in table:
        kind = "Output" if v.causality == "output" else "ContinuousStateDerivative"
        if kind == "Output" or v.derivative:
            known = "" if v.depends is None else " ".join(str(place[d]) for d in v.depends)
            depends = "" if v.depends is None else f' dependencies="{known}"'
            unknowns[kind].append(f' {key}="{place[v.name]}"{depends}/>')
    if version == 2:
        groups = zip(("Outputs", "Derivatives"), unknowns.values(), strict=True)
        listed = "".join(
            f"<{g}>{''.join(f'<Unknown{u}' for u in inside)}</{g}>"
            for g, inside in groups
            if inside
        )
        root = f'fmiVersion="2.0" guid="{token or name}"'
    else:
        texts.append(
            f'<Float64 name="time" valueReference="{TIME}" causality="independent"'
            ' variability="continuous"/>'
        )
        listed = "".join(f"<{kind}{u}" for kind, inside in unknowns.items() for u in inside)
        listed += structure
        root = f'fmiVersion="3.0" instantiationToken="{token or name}"'
    kinds = "".join(f'<{i} modelIdentifier="{name}" {flags}/>' for i, flags in interfaces.items())
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription {root} modelName="{name}"'
        f" {head}>{kinds}{types}<DefaultExperiment {experiment}/>"
        f"<ModelVariables>{''.join(texts)}</ModelVariables>"
        f"<ModelStructure>{listed}</ModelStructure></fmiModelDescription>"
    )


def _variable(reference: int, v: Variable, version: int, place: Mapping[str, int]) -> str:
    varies = "continuous" if v.type.startswith("Float") else "discrete"
    varies = v.variability or ("fixed" if "arameter" in v.causality else varies)
    common = f'name="{v.name}" valueReference="{reference}" causality="{v.causality}"'
    common += f' variability="{varies}"' + (f' initial="{v.initial}"' if v.initial else "")
    as_element = v.type in {"String", "Binary"} and version == 3
    typed = "" if v.start is None or as_element else f' start="{v.start}"'
    if v.derivative:
        typed += f' derivative="{place[v.derivative]}"'
    typed += f" {v.attributes}"
    if version == 2:
        return f"<ScalarVariable {common}><{FMI2_TYPES[v.type]}{typed}/></ScalarVariable>"
    inside = "".join(f"<Dimension {d}/>" for d in v.dimensions) + v.inside
    inside += f'<Start value="{v.start}"/>' if as_element and v.start is not None else ""
    return f"<{v.type} {common}{typed}>{inside}</{v.type}>"


def headers(versions: Iterable[int] = (2, 3)) -> dict[str, str]:
    """Return the headers of these versions of FMI, as the compiler takes them."""
    folder = resources.files("fmpy") / "c-code"
    begin = tuple(f"fmi{version}" for version in versions)
    found = (file for file in folder.iterdir() if file.name.startswith(begin))
    return {f"system/{file.name}": file.read_text(encoding="utf-8") for file in found}


def library(
    name: str,
    *sources: Path,
    flags: Sequence[str] = (),
    versions: Iterable[int] = (2, 3),
    complete: bool = True,
) -> Path:
    """Return a library of these sources; if ``complete``, functions they lack return an error."""
    files = headers(versions)
    names = re.findall(r"FMI[23]_Export fmi[23]\w+TYPE\s+(\w+);", "".join(files.values()))
    stubs = (f"__attribute__((weak)) EXPORT int {name}(void) {{ return 3; }}\n" for name in names)
    if complete:
        files["absent.c"] = EXPORT + "".join(dict.fromkeys(stubs))
    shared = Path(__file__).with_name("fmu.h")
    files |= {source.name: source.read_text(encoding="utf-8") for source in (shared, *sources)}
    return toolchain.shared_library(name, files, flags=flags)


def place(name: str, version: int) -> str:
    """Return where a library for this machine lies in an FMU."""
    platform = toolchain.host_platform()
    folder = platform.fmi2 if version == 2 else platform.tuple
    return f"binaries/{folder}/{name}{platform.suffix}"


def archive(path: Path, members: Mapping[str, bytes | str]) -> Path:
    """Write a zip archive."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return path


def pack(path: Path, description: str, files: Mapping[str, bytes]) -> Path:
    """Write an FMU."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return archive(path, {"modelDescription.xml": description, **files})
