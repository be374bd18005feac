"""What to do with the results."""

from __future__ import annotations

from collections.abc import Collection

from stickslip.identification.estimation import Estimation
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
)
from stickslip.report.versions import made_with

FILES = {
    "parameters.csv": "the parameters with units and intervals, unrounded, in SI units",
    "learned.json": "the same with judge, relative errors, seed and versions",
    "compensator.fmu": "the tuned compensator, for any tool that imports FMUs",
}


def write(estimation: Estimation, beside: Collection[str]) -> Html:
    """Return the last section.

    Parameters
    ----------
    beside : names of the files in the page's folder
    """
    items = [
        element("li", element("code", name), ": ", what)
        for name, what in FILES.items()
        if name in beside
    ]
    commands = []
    if "learned.json" in beside:
        commands += [
            "stickslip export compensator --parameters learned.json --as fmu",
            "stickslip export compensator --parameters learned.json --as st",
        ]
    if "compensator.fmu" in beside:
        commands.append("stickslip check compensator.fmu")
    parts = [element("h2", "Using the result"), paragraph("Beside this page lie:")]
    parts.append(element("ul", join(items, "\n")))
    if commands:
        said = "As FMU or as structured text for a PLC; --as c gives C99:"
        parts += [paragraph(said), _code(commands)]
    return element("section", *parts, *_next(estimation), made_with())


def _next(estimation: Estimation) -> list[Html]:
    """Return which experiment would show more, if any."""
    vague = [name for name, known in estimation.known.items() if known.visible != "well known"]
    if not vague:
        return []
    motion = " --motion rotary" if estimation.recording.motion == "rotary" else ""
    return [
        paragraph(
            "What this recording did not show well, another can: this writes a command that gives "
            "its time to it. A compensator whose values are guesses may push where no friction is."
        ),
        _code([f"stickslip plan --show {' '.join(vague)}{motion} --out next.csv"]),
    ]


def _code(lines: list[str]) -> Html:
    return element("pre", element("code", "\n".join(lines)))
