"""What an FMU carries besides its model: icon (SVG and PNG), plugs, documentation, results."""

import csv
import html
import io
from collections.abc import Sequence
from functools import cache
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from stickslip.fmi import toolchain
from stickslip.fmi.description import writing
from stickslip.models.errors import UnknownLaw
from stickslip.models.export.description import Model
from stickslip.models.export.law import read_toml
from stickslip.models.export.sources import text

Line = Sequence[float]
"""A polyline x1, y1, x2, y2 ... on a tile of 100 by 100, y downwards."""
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}
pre {{ font: 14px/1.4 monospace; white-space: pre-wrap; }}
</style>
</head>
<body>
<img src="../{icon}" alt="" width="96" height="96">
<pre>{body}</pre>
{notes}<h2>Licence</h2>
<p>MIT: <a href="licenses/license.txt">licenses/license.txt</a>. The functions are those of the
Functional Mock-up Interface, whose headers are under the 2-clause BSD licence.</p>
</body>
</html>
"""
_SQUARE = {"x1": 0.0, "y1": 0.0, "x2": 100.0, "y2": 100.0}
_STROKE = 5.0  # of 100
_EDGE, _CORNER = 3.0, 14.0
_TILE, _INK = "#f0f4f8", "#183e60"


def svg(lines: Sequence[Line]) -> str:
    """Return the icon as SVG."""
    pairs = [zip(line[::2], line[1::2], strict=True) for line in lines]
    points = [" ".join(f"{x:g},{y:g}" for x, y in each) for each in pairs]
    paths = "".join(f'<polyline points="{each}"/>' for each in points)
    inside = 100 - 2 * _EDGE
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'
        f'<g fill="none" stroke="{_INK}" stroke-width="{_STROKE:g}"'
        ' stroke-linecap="round" stroke-linejoin="round">'
        f'<rect x="{_EDGE:g}" y="{_EDGE:g}" width="{inside:g}" height="{inside:g}"'
        f' rx="{_CORNER:g}" fill="{_TILE}" stroke-width="{_STROKE / 2:g}"/>'
        f"{paths}</g></svg>\n"
    )


@cache
def png(lines: tuple[Line, ...]) -> bytes:
    """Return the icon as PNG, 128 by 128, with alpha."""
    parts = repr(lines), text(Path(__file__)), version("matplotlib")
    return toolchain.kept("icons", parts, lambda: _drawn(lines))


def _drawn(lines: tuple[Line, ...]) -> bytes:
    # In the default style, so that the bytes depend on the version of Matplotlib only.
    from matplotlib import style
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import FancyBboxPatch

    with style.context("default", after_reset=True):
        figure = Figure(figsize=(1.28, 1.28), dpi=100, facecolor="none")
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0, 100), ylim=(100, 0))
        axes.set_axis_off()
        inside, points = 100 - 2 * _EDGE, 1.28 * 72 / 100  # of a printer, in 1/100 of the tile
        drawing: dict[str, Any] = {"facecolor": _TILE, "edgecolor": _INK}
        drawing |= {"linewidth": _STROKE / 2 * points}
        box = f"round,pad=0,rounding_size={_CORNER}"
        axes.add_patch(FancyBboxPatch((_EDGE, _EDGE), inside, inside, boxstyle=box, **drawing))
        for line in lines:
            (drawn,) = axes.plot(line[::2], line[1::2], color=_INK, linewidth=_STROKE * points)
            drawn.set_solid_capstyle("round")
            drawn.set_solid_joinstyle("round")
        picture = BytesIO()
        FigureCanvasAgg(figure).print_png(picture, metadata={"Software": None})  # type: ignore[no-untyped-call]
    return picture.getvalue()


def terminals_and_icons(model: Model) -> str:
    """Return the XML of FMI 3.0.2, 2.6, and FMI 2.0.4; members of the same name fit."""
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = writing.child(root, "GraphicalRepresentation")
    writing.child(picture, "CoordinateSystem", **_SQUARE, suggestedScalingFactorTo_mm=0.1)
    writing.child(picture, "Icon", **_SQUARE)
    if model.terminals:
        section = writing.child(root, "Terminals")
        for name, terminal in model.terminals.items():
            named = {"name": name, "matchingRule": "plug", "description": terminal.description}
            element = writing.child(section, "Terminal", **named)
            for member, variable in terminal.members.items():
                given = {"variableName": variable, "memberName": member, "variableKind": "signal"}
                writing.child(element, "TerminalMemberVariable", **given)
    return writing.document(root)


def index(model: Model, icon: str, notes: Sequence[str] = ()) -> str:
    """Return the page, with notes on the values. ``icon`` is its path from the root of the FMU."""
    readme = model.folder / "README.md"
    text = f"# {model.title}\n\n{model.description}\n"
    if readme.exists():
        text = readme.read_text(encoding="utf-8")
    if model.law is not None:
        text += "\n" + (model.law.folder / "README.md").read_text(encoding="utf-8")
    if model.rotary:
        text = "For this rotary drive read rad for m, N m for N and kg m2 for kg.\n\n" + text
    lines = html.escape("\n".join(notes))
    values = f"<h2>Values</h2>\n<pre>{lines}</pre>\n" if notes else ""
    title, body = html.escape(model.title), html.escape(text)
    return _PAGE.format(title=title, icon=icon, body=body, notes=values)


LS_REF = "extra/org.fmi-standard.fmi-ls-ref"
# The schema of the standard allows no other.
_DESCRIPTION = "Layered Standard providing information on related files included in an FMU."
_MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"


def reference_file(model: Model) -> Path | None:
    """Return the table of a short run, a plant's for its default law; None where there is none."""
    law = model.law
    own = model.folder / "reference.csv"
    if law is None or (own.exists() and law.name == read_toml(model.folder / "model.toml")["law"]):
        return own
    if model.name == "compensator":
        return law.folder / "reference.csv"
    return None


def tables(model: Model) -> tuple[str, str]:
    """Return inputs at the beginning of each step, and outputs, as CSV with time [s] first."""
    path = reference_file(model)
    if path is None:
        raise UnknownLaw(f"no expected results of {model.name} with its friction law are known")
    head, *rows = csv.reader(io.StringIO(text(path)))
    inputs = {v.name for v in model.variables if v.role == "input"}
    chosen = [
        [k for k, name in enumerate(head) if name == "time" or (name in inputs) == wanted]
        for wanted in (True, False)
    ]
    written = []
    for columns in chosen:
        stream = io.StringIO()
        stream.write(",".join(f'"{head[k]}"' for k in columns) + "\n")
        stream.writelines(",".join(row[k] for k in columns) + "\n" for row in rows)
        written.append(stream.getvalue())
    return written[0], written[1]


def span(model: Model) -> tuple[float, float]:
    """Return stop time and step [s] of the reference."""
    times = [float(line.split(",")[0]) for line in tables(model)[1].splitlines()[1:]]
    return times[-1], times[1] - times[0]


def layered_standard(model: Model) -> dict[str, str]:
    """Return the files of FMI-LS-REF 1.0.0-alpha.1 (modelica/fmi-ls-ref) by path in the FMU."""
    stimuli, references = f"{model.name}_in.csv", f"{model.name}_out.csv"
    ET.register_namespace("fmi-ls", _MANIFEST)
    named = {"name": "org.fmi-standard.fmi-ls-ref", "version": "1.0.0-alpha.1"}
    named |= {"description": _DESCRIPTION}
    written = {f"{{{_MANIFEST}}}fmi-ls-{key}": value for key, value in named.items()}
    manifest = ET.Element("fmiReferences", written)
    related = (
        ("experiments.xml", "text/xml", "experiment/validation", "Run with known results"),
        (stimuli, "text/csv", "testcase", "Inputs of that run, held over each step"),
        (references, "text/csv", "result", "Outputs of that run, calculated without this FMU"),
    )
    for source, kind, role, said in related:
        given = {"type": kind, "source": source, "role": role, "description": said}
        writing.child(manifest, "Related", **given)
    stop, step = span(model)
    experiments = ET.Element("Experiments")
    named = {"name": "Reference", "description": "Start values of modelDescription.xml"}
    times = {"startTime": 0.0, "stopTime": stop, "stepSize": step}
    run = writing.child(experiments, "Experiment", **named, **times)
    writing.child(run, "Stimuli", source=stimuli, type="text/csv")
    writing.child(run, "References", source=references, type="text/csv")
    content = {
        "fmi-ls-manifest.xml": writing.document(manifest),
        "experiments.xml": writing.document(experiments),
        **dict(zip((stimuli, references), tables(model), strict=True)),
    }
    return {f"{LS_REF}/{name}": text_ for name, text_ in content.items()}
