"""A job that learns."""

import os
from functools import partial

from stickslip.studies.fleet import study
from stickslip.studies.learn.log_learning import learn
from tests.stickslip.brief import briefly


def brief(drive, seed, on_stage=None):
    """Learn a drive briefly, for one compensator; write down in which process."""
    with briefly() as patch:
        patch.setattr(study, "learn", partial(learn, law="lugre", compensator="static"))
        outcome = study.learn_drive(drive, seed, on_stage)
    drive.files["log"].with_name(f"{drive.name}.pid").write_text(str(os.getpid()))
    return outcome
