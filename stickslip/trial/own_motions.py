"""Motions that a drive will make, on which compensators are compared in place of typical ones.

Whether a compensator helps in a small move depends on its length: where the loop just does not
break away without it, it may do harm. A block cannot know how long a move will be; its user can.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from stickslip.errors import RecordingError
from stickslip.evaluation.tracking import commanded_velocity
from stickslip.logs import Description, Recording, read_recording
from stickslip.trial.family import Command

LONGEST = 60.0  # of all motions together [s]: each runs some hundred times


def read_motions(
    paths: Iterable[Path | str], description: Description, like: Recording
) -> tuple[Command, ...]:
    """Return the commands in files, at the sample period of a recording of the same drive.

    A file has the columns of the log that ``description`` describes, or those of a plan. Raises
    RecordingError where one has no command, or stands still, or all together are too long.
    """
    found, duration = [], 0.0
    for path in map(Path, paths):
        recording = _read(path, replace(description, motion=like.motion))
        if duration + recording.t[-1] > LONGEST:
            raise RecordingError(
                f"{path}: the motions take {duration + recording.t[-1]:.0f} s; expected at most"
                f" {LONGEST:.0f} s together; cut out those that matter"
            )
        duration += recording.t[-1]
        v = commanded_velocity(replace(recording, source=str(path)))
        t = np.arange(int(recording.t[-1] / like.T_s) + 1) * like.T_s
        v_cmd = np.interp(t, recording.t, v)
        if not v_cmd.any():
            raise RecordingError(f"{path}: the command stands still; expected a motion")
        found.append(Command(path.stem, v_cmd))
    return tuple(found)


def _read(path: Path, description: Description) -> Recording:
    own = replace(description, controller="none", gains={}, encoder_step=None, span=None)
    try:
        return read_recording(path, own, commands=True).recording
    except RecordingError:
        if not own.columns:
            raise
    bare = replace(own, columns={}, sample_period=None)  # a plan has names of its own
    return read_recording(path, bare, commands=True).recording
