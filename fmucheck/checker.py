"""From a file to its report: stage after stage, as far as each allows."""

import math
import time
from collections.abc import Iterable
from pathlib import Path

from stickslip.fmi.process import temporary_folder
from stickslip.fmi.process.sandbox import Permissions
from stickslip.fmucheck.archive import read_archive, unpack, zip_bomb
from stickslip.fmucheck.description.model import Description, Fmu
from stickslip.fmucheck.document import checked_version, claimed_version, read_document
from stickslip.fmucheck.rules import Report, grouped, stage
from stickslip.fmucheck.running.parent import TIMEOUT, Limits, findings_of_runs

_DESCRIPTION = "modelDescription.xml"
_BLOCKING = {"schema-violation", "bad-model-identifier", "bad-dimension", "unknown-version"}
"""Rules whose findings make running pointless or dangerous."""
_UNLOADABLE = {"not-a-library", "wrong-architecture"}
"""Rules whose findings do so for the binary that they name, whatever the others are."""


def check(
    path: Path | str,
    *,
    run: bool = True,
    timeout: float = TIMEOUT,
    total: float = math.inf,
    allow: Iterable[str] = (),
) -> Report:
    """Check one FMU.

    Nothing outside a temporary folder is written, and the folder is gone afterwards.

    Parameters
    ----------
    run : also load the binary for this machine and run it, in a child process
    timeout : s that the binary may take for one rule
    total : s that all rules together may take; what is known by then is reported
    allow : what the sandbox lets the binary do, on Linux: ``network``, ``exec``, ``files=DIR``,
        ``env=NAME``

    Raises
    ------
    OSError
        When the file does not exist, or there is no room for temporary files.
    ValueError
        When something else is to be allowed.
    """
    Permissions.of(allow := tuple(allow))
    limits = Limits(timeout, time.monotonic() + total, allow)
    report = Report(Path(path))
    report.path.stat()
    archive = read_archive(report.path)
    with temporary_folder("fmucheck-") as folder:
        content = folder / "fmu"
        content.mkdir()
        members: frozenset[str] = frozenset()
        if archive.fault is None and not any(zip_bomb(archive)):
            members = unpack(archive, content)
        _apply(report, "archive", archive, None)
        if fmu := _check_content(report, members, content):
            blocked = report.rules & _BLOCKING
            broken = {f.place: f.rule for f in report if f.rule in _UNLOADABLE}
            runs = findings_of_runs(fmu, blocked, broken, limits) if run else ()
            report.findings += runs
    report.findings = grouped(report.findings)
    return report


def _apply(report: Report, name: str, subject: object, version: int | None) -> None:
    for rule in stage(name):
        report.findings += rule.findings(subject, version)


def _check_content(report: Report, members: frozenset[str], folder: Path) -> Fmu | None:
    if _DESCRIPTION not in members:
        return None
    document = read_document(_DESCRIPTION, (folder / _DESCRIPTION).read_bytes())
    report.fmi = claimed_version(document)
    version = checked_version(document)
    _apply(report, "document", document, version)
    if document.root is None or version is None:
        return None
    description = Description(document.root, version)
    _apply(report, "description", description, version)
    fmu = Fmu(report.path, folder, members, description)
    _apply(report, "files", fmu, version)
    _apply(report, "binaries", fmu, version)
    return fmu
