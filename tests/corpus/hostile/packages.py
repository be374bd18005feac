"""System structure packages of the reference FMU, sound but for what a case spoils."""

from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path

from tests.corpus.defects import reference
from tests.corpus.fmu import archive

Text = str | bytes
STRUCTURE = "SystemStructure.ssd"
_NAMES = {
    "ssd": "Description",
    "ssc": "Common",
    "ssv": "ParameterValues",
    "ssm": "ParameterMapping",
    "ssb": "SignalDictionary",
}
_ROOT = "http://ssp-standard.org/SSP1/SystemStructure"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
TIMES = 'startTime="0" stopTime="1"'


def document(root: str, inside: str, version: str = "1.0", name: str = "n") -> str:
    """Return a file of SSP."""
    declared = "".join(f' xmlns:{p}="{_ROOT}{part}"' for p, part in _NAMES.items())
    named = "" if root in {"ssm:ParameterMapping", "ssb:SignalDictionary"} else f' name="{name}"'
    return f'<{root} version="{version}"{named}{declared}>{inside}</{root}>'


def component(name: str, inside: str = "", *, fmu: object = 2) -> str:
    """Return a component; by default the reference FMU: y = x + d u, of u [m/s] and x, y [m]."""
    return f'<ssd:Component name="{name}" source="resources/{fmu}.fmu">{inside}</ssd:Component>'


def connection(
    start: str, end: str, inside: str = "", *, convert: bool = False, **more: str
) -> str:
    """Return a connection of ``element.connector``; by default units are not converted."""
    words = [f'{name}="{text}"' for name, text in more.items()]
    for which, (element, _, connector) in (
        ("start", start.rpartition(".")),
        ("end", end.rpartition(".")),
    ):
        words += [f'{which}Element="{element}"'] if element else []
        words += [f'{which}Connector="{connector}"']
    if not convert:
        words.append('suppressUnitConversion="true"')
    return f"<ssd:Connection {' '.join(words)}>{inside}</ssd:Connection>"


def connector(name: str, kind: str, value: str = "<ssc:Real/>") -> str:
    """Return a connector."""
    return f'<ssd:Connector name="{name}" kind="{kind}">{value}</ssd:Connector>'


def values(*pairs: tuple[str, str]) -> str:
    """Return an .ssv file of numbers by name."""
    inside = "".join(
        f'<ssv:Parameter name="{name}"><ssv:Real value="{value}"/></ssv:Parameter>'
        for name, value in pairs
    )
    return document("ssv:ParameterSet", f"<ssv:Parameters>{inside}</ssv:Parameters>")


def bound(inside: str) -> str:
    """Return bindings with what is inside of one."""
    return f"<ssd:ParameterBindings>{inside}</ssd:ParameterBindings>"


def binding(source: str, mapping: str = "") -> str:
    """Return bindings to one .ssv file, by way of an .ssm file or not."""
    through = f'<ssd:ParameterMapping source="{mapping}"/>' if mapping else ""
    return bound(f'<ssd:ParameterBinding source="{source}">{through}</ssd:ParameterBinding>')


def experiment(step: str = "0.1", times: str = TIMES, declared: str = f'xmlns:osp="{OSP}"') -> str:
    """Return the times that a package proposes."""
    return (
        f'<ssd:DefaultExperiment {times}><ssd:Annotations><ssc:Annotation type="com.'
        f'opensimulationplatform"><osp:Algorithm {declared}><osp:FixedStepAlgorithm'
        f' baseStepSize="{step}"/></osp:Algorithm></ssc:Annotation></ssd:Annotations>'
        "</ssd:DefaultExperiment>"
    )


def system(
    name: str,
    elements: str,
    connections: Sequence[str] = (),
    *,
    connectors: str = "",
    before: str = "",
    behind: str = "",
) -> str:
    """Return a system; ``before`` comes before its elements, ``behind`` behind its connections."""
    joined = f"<ssd:Connections>{''.join(connections)}</ssd:Connections>" if connections else ""
    ends = f"<ssd:Connectors>{connectors}</ssd:Connectors>" if connectors else ""
    inside = f"{ends}{before}<ssd:Elements>{elements}</ssd:Elements>{joined}{behind}"
    return f'<ssd:System name="{name}">{inside}</ssd:System>'


def structure(
    elements: str,
    connections: Sequence[str] = (),
    *,
    rest: str = "",
    times: str | None = None,
    version: str = "1.0",
    name: str = "n",
    **parts: str,
) -> str:
    """Return a SystemStructure.ssd; times are a DefaultExperiment, parts as of ``system``."""
    proposed = experiment() if times is None else times
    whole = system("s", elements, connections, **parts) + rest + proposed
    return document("ssd:SystemStructureDescription", whole, version, name)


def packed(text: Text, files: Mapping[str, Text] | None = None) -> Callable[[Path], None]:
    """Return what writes a package of a structure, files, and the reference FMUs 2.fmu, 3.fmu."""

    def write(path: Path) -> None:
        fmus = {}
        for fmi in (2, 3):
            reference.pack(file := BytesIO(), reference.members(fmi))
            fmus[f"resources/{fmi}.fmu"] = file.getvalue()
        archive(path, {STRUCTURE: text, **(files or {}), **fmus})

    return write
