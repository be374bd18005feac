"""Jobs that stand for learning: quick, brief, and misbehaving where a name says so."""

import json
import os
import signal
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from stickslip.learned.writing import SCHEMA, versions
from stickslip.work.jobs import Outcome


def quick(drive, seed, _=None):
    """Learn one parameter that depends on nothing but the drive."""
    value = 1.0 / (seed + len(drive.name))
    known = {"value": value, "unit": "N", "standard_error": 0.01, "low": value - 0.02}
    known |= {"high": value + 0.02, "identifiability": "identifiable", "sentence": "identifiable"}
    document = {"schema": SCHEMA, "parameters": {"F_c": known}, "criterion": "none"}
    document |= {"seed": seed, "versions": versions()}
    return Outcome(json.dumps(document))


@dataclass(frozen=True)
class Deadly:
    """As `quick`, but the process dies of drives called ``kills``."""

    parent: int

    def __call__(self, drive, seed, _=None):
        time.sleep(0.05)
        if drive.name == "kills":
            assert os.getpid() != self.parent
            os.kill(os.getpid(), signal.SIGKILL)
        return quick(drive, seed)


@dataclass(frozen=True)
class Counting:
    """As `quick`, writing down whom it learns; Ctrl-C comes when it is one drive's turn."""

    diary: Path
    interrupted_at: str = ""

    def __call__(self, drive, seed, _=None):
        if drive.name == self.interrupted_at:
            raise KeyboardInterrupt
        with self.diary.open("a", encoding="utf-8") as diary:
            print(drive.name, file=diary)
        return quick(drive, seed)


def brief(drive, seed, on_stage=None):
    """Learn a drive briefly, for one compensator; write down in which process."""
    from stickslip.studies.fleet import study  # takes seconds, and the other jobs do without
    from stickslip.studies.learn.log_learning import learn
    from tests.stickslip.brief import briefly

    with briefly() as patch:
        patch.setattr(study, "learn", partial(learn, law="lugre", compensator="static"))
        outcome = study.learn_drive(drive, seed, on_stage)
    drive.files["log"].with_name(f"{drive.name}.pid").write_text(str(os.getpid()))
    return outcome
