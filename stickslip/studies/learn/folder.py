"""The folder that ``stickslip learn`` leaves behind."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stickslip.errors import with_settings
from stickslip.learned import deploying
from stickslip.learned.file import LearnedFile
from stickslip.presentation.page import Section, picture_files
from stickslip.storage import staged
from stickslip.storage.codec import encode
from stickslip.storage.writing import write_json, write_tables
from stickslip.studies.learn import tables
from stickslip.studies.learn.document import log_document
from stickslip.studies.learn.learned import LearnedFromRecording
from stickslip.studies.learn.page import FILES as REPORT
from stickslip.studies.learn.page import compensation, write_estimation_report
from stickslip.studies.learn.page.tracking import FIGURE as TRACKING
from stickslip.studies.learn.page.tracking import tracking_section
from stickslip.studies.learn.verdict import (
    COMPENSATOR,
    ERROR,
    OBSERVER_FMU,
    POSITION_FMU,
    Verdict,
    file_names,
    reasons,
    refusals,
    verdict_of,
    verdict_section,
)

FMUS = (COMPENSATOR, OBSERVER_FMU, POSITION_FMU)
TABLE = "tracking_error.csv"  # Errors on the family of simulated drives
PICTURES = (ERROR, TRACKING)  # of the page's opening
FILES = ("learned.json", *FMUS, *deploying.FILES, TABLE, *picture_files(PICTURES), *REPORT)
"""What ``write_learned`` writes or removes."""


@dataclass(frozen=True)
class Written:
    """What ``write_learned`` wrote."""

    learned: LearnedFromRecording  # as it is recommended
    files: tuple[str, ...]  # names of the FMUs in the folder
    forced: bool  # whether what is refused was to be written, and the whole force

    def document(self) -> dict[str, Any]:
        """Return the content of learned.json."""
        one = self.learned
        found = log_document(one.with_whole_force() if self.forced else one)
        entry = {"files": list(self.files), "forced": self.forced}
        return found | {
            "refusal": one.refusal,
            "written": entry,
            "verdict": encode(self.verdict) | {"lines": [*map(list, self.verdict.rows())]},
        }

    @property
    def verdict(self) -> Verdict:
        """What is to be known first."""
        return verdict_of(self.learned, self.files, force=self.forced)

    @property
    def sentences(self) -> tuple[str, ...]:
        """What is written and why, or refused, a line each."""
        one = self.learned
        parts = one.writes(force=self.forced)
        found = [f"written: {parts or 'no compensation'}"]
        if one.trial:
            compared = one.trial.compared
            found[0] += (
                f" ({compared.chosen.name}): " if parts and compared.chosen.benefit else ": "
            )
            found[0] += compared.sentence
        return (*found, *refusals(one, self.files, force=self.forced))


def write_learned(
    learned: LearnedFromRecording, folder: Path | str, *, force: bool = False
) -> Written:
    """Write learned.json, report and, if nothing speaks against it or it is forced, what is used.

    That are the FMUs, and their code in ``deploy`` with a page of steps.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    folder = Path(folder)
    command = {"name": "learn", "log": learned.estimation.recording.source, "seed": learned.seed}
    shown = learned.with_whole_force() if force else learned
    without = [*FMUS, *deploying.FILES, TABLE, *picture_files(PICTURES)]
    with staged(folder, command, without=without) as staging:
        if shown.trial:
            write_tables({TABLE.removesuffix(".csv"): shown.trial.table()}, staging)
        written = Written(learned, file_names(learned, force=force), force)
        write_json(written.document(), staging / "learned.json")
        if written.files:
            own = LearnedFile(staging / "learned.json")
            deploying.build_parts(own, staging, _notes(learned))
            deploying.write_deployment(own, staging / deploying.FOLDER)
        motion = shown.estimation.recording.motion
        opening = [verdict_section(written.verdict, motion)]
        if shown.tracking and shown.trial:
            opening.append(tracking_section(shown.tracking, motion, shown.run))
        tried = [compensation(shown.trial)] if shown.trial and shown.benefit else []
        write_estimation_report(  # last: its page names the files beside it
            learned.estimation,
            learned.findings,
            staging,
            _others(learned) + tried,
            opening=opening,
            forced=force,
        )
    return written


def _others(learned: LearnedFromRecording) -> list[Section]:
    """Return the section on logs that were not learned from, if there are any."""
    table = tables.predicted_logs(
        learned.predicted, rotary=learned.estimation.recording.rotary
    ).html("Root mean square of measured minus predicted force; nothing is fitted to these logs")
    title = "Logs that were not learned from"
    return [Section(title, "{{ table }}", table=table)] if learned.predicted else []


def _notes(learned: LearnedFromRecording) -> dict[str, str]:
    """Return why FMUs are not recommended, by their names, for their descriptions."""
    start = with_settings("Written with <force>; learn does not recommend it: ")
    return {Path(name).stem: start + why for name, why in reasons(learned).items() if why}
