"""Pages that follow from the code: public names, commands, rules, malformed inputs, samples."""

from __future__ import annotations

import argparse
import base64
import inspect
import json
import re
import sys
import textwrap
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd

import stickslip
from stickslip import cli, thresholds
from stickslip.fmucheck import rules
from stickslip.logs import read_recording
from stickslip.presentation import style

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tests.corpus.hostile import CASES, GROUPS  # noqa: E402
from tests.stickslip.logs import format_writers as writers  # noqa: E402
from tests.stickslip.logs.test_vendors import FILES, F, T, V, X  # noqa: E402

HEADINGS = {
    "Systems and runs": ("cosim", "blocks", "contents", "simulation", "sweeping"),
    "Models and friction laws": ("models", "laws"),
    "Velocity loops and frequency responses": ("servo", "cosim.control", "presentation"),
    "Learning": ("logs", "planning", "identification", "output", "studies.learn", "learned"),
    "Drives": ("rigs", "drives"),
    "Comparison and checks": ("studies.arena", "studies.compare", "fmucheck", "fmi"),
}
"""The packages whose public names stand under each heading; the longest name counts."""


def write(folder: Path) -> None:
    """Write all pages; what is equal keeps its time, so that only changes are built again."""
    _samples(folder / "samples")
    pages: dict[str, str | bytes] = {"api.rst": _api(), "cli.rst": _commands()}
    pages |= {"check-rules.inc": rules.table(), "hostile-cases.inc": _hostile()}
    pages |= {"thresholds.inc": _thresholds(), "errors.inc": _errors()}
    pages |= {"drives.inc": _drives(), "drives.png": _friction_curves()}
    for path in sorted((ROOT / "notebooks").glob("*.ipynb")):
        pages[f"{path.stem}.png"] = _picture(path)
    spec = find_spec("sphinx-mathjax-offline")
    if spec and spec.origin:  # of its 24 MB, what pages load
        source = Path(spec.origin).parent / "static" / "mathjax" / "tex-svg.js"
        pages["static/mathjax.js"] = source.read_bytes()
    for name, content in pages.items():
        data = content.encode() if isinstance(content, str) else content
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_bytes() != data:
            path.write_bytes(data)


def _api() -> str:
    """Return the page of the public names, by heading; packages have headings of their own."""
    place = {package: heading for heading, packages in HEADINGS.items() for package in packages}
    names: dict[str, list[str]] = {heading: [] for heading in HEADINGS}
    for name in stickslip.__all__:
        value = getattr(stickslip, name)
        if inspect.ismodule(value):
            inner = {*getattr(value, "__all__", ())} - {*stickslip.__all__}
            listed = [f"{name}.{one}" for one in inner if callable(getattr(value, one))]
            names[f"stickslip.{name}"] = listed
            continue
        package = _package(name)
        while package and package not in place:
            package = package.rpartition(".")[0]
        names.setdefault(place.get(package, "Others"), []).append(name)
    lines = [*_heading("Python", "="), "``import stickslip as ss`` gives these names."]
    lines += ["Quantities are in SI units unless a docstring states another.", ""]
    for heading, group in ((heading, group) for heading, group in names.items() if group):
        lines += _heading(heading, "-")
        lines += [".. currentmodule:: stickslip", "", ".. autosummary::", "   :toctree: api"]
        lines += ["   :nosignatures:", ""]
        lines += [*(f"   {name}" for name in sorted(group, key=str.lower)), ""]
    return "\n".join(lines)


def uses() -> dict[str, list[tuple[str, str]]]:
    """Return title and name of the pages and notebooks that use a public name, by its full name."""
    found: dict[str, list[tuple[str, str]]] = {}
    for path in (*sorted(ROOT.glob("docs/*.md")), *sorted(ROOT.glob("notebooks/*.ipynb"))):
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".ipynb":
            sources = ("".join(cell["source"]) for cell in json.loads(text)["cells"])
            text = "\n".join(sources)
        title = re.search(r"^# (.+)", text, re.MULTILINE)
        place = f"/{path.relative_to(ROOT).with_suffix('').as_posix()}"
        for name in sorted({*re.findall(r"\bss\.((?:[a-z]+\.)?\w+)", text)}):
            found.setdefault(f"stickslip.{name}", []).append((title[1] if title else name, place))
    return found


def _errors() -> str:
    """Return the errors that a user can cause, each below what it is a kind of."""

    def lines(kind: type, depth: int) -> Iterator[str]:
        what = (kind.__doc__ or "").strip().partition("\n")[0]
        place = kind.__module__.partition(".errors")[0]
        if not hasattr(import_module(place), kind.__name__):
            place = kind.__module__
        yield f"{'  ' * depth}- `{place}.{kind.__name__}`: {what}"
        for below in sorted(kind.__subclasses__(), key=lambda one: one.__name__):
            if below.__module__.startswith("stickslip") and below.__name__[0] != "_":
                yield from lines(below, depth + 1)

    for module in ("cosim", "ga", "models", "fmucheck", "studies.arena.comparison"):
        import_module(f"stickslip.{module}")
    return "\n".join(lines(stickslip.Fault, 0)) + "\n"


def _package(name: str) -> str:
    """Return where the declarations for type checkers take a public name from."""
    stub = (ROOT / "stickslip" / "__init__.pyi").read_text(encoding="utf-8")
    found = re.search(rf"^from stickslip\.(\S+) import {name} as {name}$", stub, re.MULTILINE)
    return found[1] if found else ""


def _commands() -> str:
    """Return the page of all commands."""
    lines = [*_heading("Command line", "="), "Files and options come in any order. Each command"]
    lines += ["has ``--json``, ``--quiet``, ``--verbose`` and ``--debug``.", ""]
    for name, (_, does) in cli.COMMANDS.items():
        parser = _choices(cli._parser([name]))[name]  # noqa: SLF001 - the parser is its content
        lines += [*_heading(f"stickslip {name}", "-"), f"{does[0].upper()}{_plain(does[1:])}.", ""]
        exports = _choices(parser)
        for what, inner in exports.items():
            lines += [*_heading(f"stickslip {name} {what}", "~"), *_options(inner)]
        if not exports:
            lines += _options(parser)
    return "\n".join(lines)


def _choices(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the commands of a parser by name."""
    for action in parser._actions:  # noqa: SLF001 - argparse has no other list of them
        if action.nargs == argparse.PARSER:
            return dict(action.choices)
    return {}


def _options(parser: argparse.ArgumentParser) -> list[str]:
    """Return the usage of a command, and what its words mean."""
    usage = parser.format_usage().removeprefix("usage: ").strip()
    usage = re.sub(r"\[-h\]\s+\[--json\]\s+\[-q\]\s+\[-v\]\s+\[--debug\]\s*", "", usage)
    lines = [".. code-block:: text", "", *(f"   {row.strip()}" for row in usage.splitlines()), ""]
    formatter = parser._get_formatter()  # noqa: SLF001 - it writes metavars and defaults as --help
    for action in parser._actions:  # noqa: SLF001
        common = {"-h", "--json", "-q", "-v", "--debug"} & {*action.option_strings}
        if common or action.help == argparse.SUPPRESS:
            continue
        words = formatter._format_action_invocation(action)  # noqa: SLF001
        text = formatter._expand_help(action) if action.help else ""  # noqa: SLF001
        lines += [f"``{words}``", f"   {_plain(text) or 'see the usage.'}", ""]
    return lines


def _hostile() -> str:
    """Return the malformed inputs by group, with the answer to each."""
    lines: list[str] = []
    for number, group in GROUPS.items():
        lines += [f"### {number}. {group}", "", "| case | line |", "|---|---|"]
        for case in CASES:
            if case.group == number:
                about = re.sub(r"([\\|`*_<>\[\]])", r"\\\1", case.about)
                says = case.says.replace("|", "\\|").replace("`", "'")
                lines.append(f"| {about} | `{says}` |")
        lines.append("")
    return "\n".join(lines)


def _thresholds() -> str:
    """Return the numbers that decide, a table for each decision."""
    files = {int(path.name[:4]): path.name for path in (ROOT / "docs/decisions").glob("0*.md")}

    def linked(evidence: str) -> str:
        text = re.sub(r"docs/(\S+\.md)", r"[\1](\1)", evidence)
        return re.sub(
            r"decision (\d+)", lambda found: f"[{found[0]}](decisions/{files[int(found[1])]})", text
        )

    lines: list[str] = []
    for name, module in thresholds.modules().items():
        lines += [f"## `{name}`", "", module.__doc__ or "", ""]
        lines += ["| name | value | unit | meaning | evidence |", "|---|---|---|---|---|"]
        for one, value, meaning in thresholds.meanings(module):
            cells = f"`{one}`", f"{value:g}", value.unit, _plain(meaning), linked(value.evidence)
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def _drives() -> str:
    """Return the published drives with their parameters."""
    lines: list[str] = []
    for name in stickslip.drive_names():
        title, *rows = str(stickslip.drive(name)).splitlines()
        shown = [row if row.startswith("  ") else textwrap.fill(row, 100) for row in rows]
        lines += [f"## `{name}`", "", f"{_plain(title)}.", "", "```text", *shown, "```", ""]
    return "\n".join(lines)


def _friction_curves() -> bytes:
    """Return a picture of the steady friction of the published drives."""
    v, labels = np.logspace(-5, 1, 400), dict[tuple[float, ...], list[str]]()
    for name in stickslip.drive_names():
        values = {"delta": 1.0} | {**stickslip.drive(name).values}  # noqa: PD011 - of no table
        rise, scale = values["F_s"] / values["F_c"] - 1.0, values["F_c"] / values["b"]
        shape = (rise, scale / values["v_s"], values["delta"]) if rise else (0.0, 1.0, 1.0)
        labels.setdefault(shape, []).append(name)
    content = BytesIO()
    with style.house_style():
        figure = style.new_figure(120.0, 80.0)
        axes = figure.subplots()
        for (rise, scale, delta), names in labels.items():
            curve = 1.0 + rise * np.exp(-((v * scale) ** delta)) + v
            axes.loglog(v, curve, label=textwrap.fill(", ".join(names), 24))
        axes.set(xlabel=r"speed relative to $F_c / b$", ylabel=r"friction relative to $F_c$")
        axes.legend()
        figure.savefig(content, format="png", dpi=200)
    return content.getvalue()


def _samples(folder: Path) -> None:
    """Write a small log of each format, and beside it what is detected in it."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("twincat pairs", "startdrive", "tia"):
        (folder / f"{name.partition(' ')[0]}.csv").write_bytes(FILES[name].encode("latin-1"))
    columns = {"time [s]": T, "position [mm]": 1e3 * X, "force [N]": F, "v_cmd [mm/s]": 1e3 * V}
    table = pd.DataFrame(columns)
    table.to_csv(folder / "plain.csv", index=False, float_format="%.9g")
    table.to_parquet(folder / "parquet.parquet")
    named = {name.partition(" [")[0]: values for name, values in columns.items()}
    writers.tdms(folder / "tdms.tdms", columns)
    writers.mdf(folder / "mdf.mf4", columns)
    writers.excel(folder / "excel.xlsx", columns)
    writers.hdf5(folder / "hdf5.h5", columns)
    writers.simulink(folder / "simulink.mat", {**named, "position": X, "v_cmd": V})
    writers.cells(folder / "dspace.mat", columns)
    for path in [*folder.iterdir()]:
        if path.suffix != ".txt":
            reading = read_recording(path)
            np.testing.assert_allclose(reading.recording.position, X, atol=1e-9)
            found = [str(finding).partition("; --column")[0] for finding in reading.findings]
            lines = [textwrap.fill(line, 80, subsequent_indent="    ") for line in found]
            path.with_suffix(".txt").write_text("\n".join(lines), encoding="utf-8")


def _heading(text: str, line: str) -> list[str]:
    return [text, line * len(text), ""]


def _plain(text: str) -> str:
    """Return text as it is, without roles and emphasis."""
    return re.sub(r"([\\*`|_])", r"\\\1", " ".join(text.split()))


def _picture(path: Path) -> bytes:
    """Return the first picture of a notebook."""
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", {}):
                return base64.b64decode("".join(output["data"]["image/png"]))
    raise ValueError(f"{path} shows no picture")
