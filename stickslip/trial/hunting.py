"""Limit cycles: stick-slip at a constant command, at rest or at a slow speed."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from stickslip.servo.axis import Axis
from stickslip.servo.measurement import Array
from stickslip.thresholds import caution
from stickslip.trial.single_run import Finding, Trial

HOLD = 1.0  # for how long the end of the command is held, to see what goes on there [s]


def hunting(trial: Trial) -> list[Finding]:
    """Return a finding for the plateau on which the compensated loop swings most.

    The second half of each plateau is evaluated: its velocity may swing by its own speed, or by v_s
    where it is slower than that.
    """
    held = np.full(round(HOLD / trial.loop.T_s), trial.v_cmd[-1])
    longer = dataclasses.replace(trial, v_cmd=np.concatenate([trial.v_cmd, held]))
    with longer.runs(compensated=True) as run:
        v = run.velocity()
    findings = []
    still = caution.STANDING * float(np.abs(trial.v_cmd).max())
    for begin, end in _plateaus(longer.v_cmd, round(caution.PLATEAU / trial.loop.T_s)):
        speed = abs(float(longer.v_cmd[begin]))
        swing = float(np.ptp(v[(begin + end) // 2 : end]))
        limit = max(speed, trial.friction.get("v_s", still))
        if swing > limit:
            findings.append(_finding(speed, swing, limit, trial.loop.axis))
    return sorted(findings, key=lambda finding: finding.limit / finding.figure)[:1]


def _finding(speed: float, swing: float, limit: float, axis: Axis) -> Finding:
    unit = axis.unit("mm/s")
    message = (
        f"the velocity swings by {1e3 * swing:.3g} {unit} while {1e3 * speed:.3g} {unit} is"
        f" commanded; expected at most {1e3 * limit:.3g} {unit}; raise K_p, lower K_i, or command"
        " faster"
    )
    return Finding("hunting", swing, limit, axis.unit("m/s"), message=message)


def _plateaus(v_cmd: Array, least: int) -> Iterator[tuple[int, int]]:
    """Yield begin and end of the stretches on which the command is constant."""
    constant = np.abs(np.diff(v_cmd)) <= 1e-12
    ends = np.flatnonzero(np.diff(constant, prepend=False, append=False))
    for begin, end in zip(ends[::2], ends[1::2], strict=True):
        if end - begin >= least:
            yield int(begin), int(end)
