"""The recording: what reading and checks found, and its signals."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from stickslip.identification.estimation import Estimation
from stickslip.logs import Finding
from stickslip.report.markup import (
    Html,
    element,
    paragraph,
    table,
)
from stickslip.report.picture import Picture
from stickslip.report.shown import figure

ORDER = ("error", "warning", "note")


def write(
    estimation: Estimation, findings: Collection[Finding], pictures: Mapping[str, Picture]
) -> Html:
    """Return the section on the log, errors and warnings first."""
    done = (Finding("note", remark) for remark in estimation.remarks)
    faults = (fault for fault in estimation.faults if fault not in findings)
    ordered = sorted([*findings, *faults, *done], key=lambda finding: ORDER.index(finding.severity))
    rows = [
        (finding.severity, _prose(finding.what), _prose(finding.figure), _prose(finding.advice))
        for finding in ordered
    ]
    head = ("", "What", "Figure", "Advice")
    return element(
        "section",
        element("h2", "The recording"),
        table(head, rows, "What reading and checks found", (0, 1, 2, 3))
        if rows
        else paragraph("Reading and checks found nothing to remark."),
        figure(
            pictures["recording"],
            "Position, velocity and force of the recording over time",
            f"{estimation.recording.source}, on an even grid. Velocity is the derivative of the "
            "position through a low-pass without phase lag.",
        ),
    )


def _prose(said: str) -> Html:
    return element("span", said.replace("+-", "±"), class_="prose")
