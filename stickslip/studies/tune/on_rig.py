"""The last steps of tuning on the drive itself: few motions, from the present to the tuned loop.

The search is on the simulated drives. The rig runs the present loop, loops between it and the tuned
one, and the tuned one, whose predicted Ms is within the limit. After each motion the log is
compared with that of the present loop; the first one that is worse than allowed ends it.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import geometric_mean

import numpy as np
from numpy.random import default_rng

from stickslip.errors import LimitError, UsageError
from stickslip.evaluation import tracking
from stickslip.learned.file import LearnedFile
from stickslip.logs import Recording
from stickslip.loops.drive_loop import DriveLoop
from stickslip.output import SILENT, Progress
from stickslip.rigs.contract import Command, Rig, refuse
from stickslip.servo.measurement import Array, smoothed
from stickslip.studies.tune import MOTIONS
from stickslip.studies.tune.run import (
    PRESENT,
    RigMotion,
    RigTrial,
    Step,
    TunedDrive,
    TuneSettings,
    tune_drive,
)
from stickslip.thresholds import caution, kept, rig_tuning
from stickslip.trial.family import MICRO
from stickslip.trial.family import Command as Motion
from stickslip.trial.hold import Hold, described, hold_time, reversals

KINDS = 3  # of motions that a loop runs, at most
_STANDING = 0.2  # rest in which the drive takes the gains that stay [s]


def tune_on_rig(
    rig: Rig,
    learned: LearnedFile,
    settings: TuneSettings | None = None,
    motions: int = MOTIONS,  # of the rig, at most
    *,
    progress: Progress = SILENT,
) -> TunedDrive:
    """Tune the loop of a learned drive, and take what also helps in a few motions of the drive.

    An observer would have to run in the drive; the loop that is tuned has none. Raises LimitError
    when a limit of the rig ends a motion of the present loop, RigError when a motion did not end
    otherwise; UsageError when the file has no loop, its sample period is not that of the rig, or no
    motion of the trial keeps the limits of the rig.
    """
    settings, start = settings or TuneSettings(), replace(DriveLoop.of(learned), observer=None)
    T_s, limits = start.loop.T_s, rig.bounds
    if not math.isclose(T_s, rig.T_s, rel_tol=1e-6):
        raise UsageError(
            f"{learned.path}: its loop has T_s = {T_s:g} s, and {rig.name} {rig.T_s:g} s; expected"
            " the same; learn with <rig>"
        )
    if motions < 2:
        raise UsageError(f"motions = {motions}: expected 2 or more")
    if limits is not None and settings.force_limit is None:
        peak = min(limits.force, learned.datasheet.peak_force)
        settings = replace(settings, force_limit=peak)
    kinds = min(KINDS, motions // 2)
    wanted = replace(settings, steps=min(KINDS, motions // kinds - 1))
    found = tune_drive(learned, wanted, progress, start=start)
    test = RigTest(rig, learned, start)
    chosen = _chosen(test, found.commands, kinds)
    if not found.is_better:
        return replace(found, on_rig=test.trial(motions, ""))
    progress.stage(f"running {len(chosen)} motions in the present loop on {rig.name}")
    for motion in chosen:
        test.run(start, PRESENT, motion)
    taken, best, stopped, last = None, 1.0, "", start
    for step in found.steps:
        progress.stage(f"running the {step.name} on {rig.name}")
        ratios: list[float] = []
        last = step.loop
        for motion in chosen:
            stopped = test.run(step.loop, step.name, motion)
            if stopped:
                break
            ratios += test.motions[-1].ratios
        if stopped:
            taken = None
            break
        if (mean := geometric_mean(ratios)) < best:
            taken, best = step, mean
    final = taken.loop if taken else start
    if last is not final:  # a command carries the gains
        still = np.zeros(max(2, round(_STANDING / T_s)))
        rig.run(Command(T_s, final.loop, velocity=still))
    return replace(_with(found, taken), on_rig=test.trial(motions, stopped))


def _chosen(test: "RigTest", commands: Sequence[Motion], kinds: int) -> list[Motion]:
    """Return motions of the trial, the fastest and others, that keep the limits of the rig."""
    within, refused = list[Motion](), ""
    firsts = {motion.name: motion for motion in reversed(commands)}  # as for the drive as fitted
    for motion in [one for one in commands if firsts[one.name] is one]:
        if motion.name == MICRO:  # the encoder shows little of them
            continue
        try:
            if test.rig.bounds is not None:
                refuse(test.rig.bounds, test.command(test.start, motion))
        except LimitError as fault:
            refused = str(fault)
        else:
            within.append(motion)
    if not within:
        raise UsageError(f"no motion of the trial keeps the limits of {test.rig.name}: {refused}")
    places = np.linspace(0, len(within) - 1, min(kinds, len(within))).round()
    return [within[int(k)] for k in places]


def _with(found: TunedDrive, taken: Step | None) -> TunedDrive:
    """Return what was found with the loop that the drive took, or the present one."""
    if taken is None:
        same = tuple(replace(row, compensated=row.without) for row in found.rows)
        return replace(found, best=found.start, rows=same, Ms=(found.Ms[0],) * 2)
    return replace(found, best=taken.loop, rows=taken.rows, Ms=(found.Ms[0], taken.Ms))


class RigTest:
    """Runs motions on a rig and compares them with those of the present loop."""

    def __init__(self, rig: Rig, learned: LearnedFile, start: DriveLoop) -> None:
        self.rig, self.learned, self.start = rig, learned, start
        self.motions: list[RigMotion] = []
        loop, self._T_s = start.loop, rig.T_s
        step = rig.datasheet.encoder_step
        self._hold = round(hold_time(loop, learned.friction, step) / self._T_s)
        self._crossover = min(loop.K_p / (2.0 * math.pi * loop.axis.m), 0.2 / self._T_s)  # [Hz]
        # Errors of velocity [m/s] and position [m] that the steps of the encoder show
        noise = tracking.measured_velocity(step * (default_rng(0).random(4096) - 0.5), self._T_s)
        self._shown = float(np.std(noise)), step / math.sqrt(12.0)
        bounds = rig.bounds
        self._peak = min(rig.datasheet.peak_force, bounds.force if bounds else math.inf)

    def command(self, one: DriveLoop, motion: Motion) -> Command:
        """Return a motion and the rest after it in a loop."""
        v_cmd = np.append(motion.v_cmd, np.zeros(self._hold))
        added = None
        if one.feedforward is not None:
            drive = tracking.LearnedDrive(one.law.name, {}, one.feedforward, one.loop)
            added = tracking.feedforward(self._recording(v_cmd, *np.zeros((2, len(v_cmd)))), drive)
        return Command(self._T_s, one.loop, velocity=v_cmd, added_force=added)

    def run(self, one: DriveLoop, name: str, motion: Motion) -> str:
        """Run a motion; return why it is worse than allowed, or an empty text."""
        command = self.command(one, motion)
        try:
            log = self.rig.run(command)
        except LimitError as fault:
            if name == PRESENT:
                raise
            return f"{name}, {motion.name}: {fault}"
        v_cmd = command.signals["v_cmd"]
        x_cmd = command.signals.get("x_cmd", np.zeros_like(v_cmd))
        shown = tracking.measured_errors(self._recording(v_cmd, log.x_enc, log.F_m), v_cmd, x_cmd)
        errors = [float(np.sqrt(np.mean(e**2))) for e in shown[: 2 if one.loop.K_x else 1]]
        rest, step = log.x_enc[-self._hold // 2 :], self.rig.datasheet.encoder_step
        unit = one.loop.axis.unit("um")
        found = RigMotion(
            name,
            motion.name,
            tuple(errors),
            force=float(np.abs(log.F_m).max()),
            ripple=float(np.std(log.F_m - smoothed(log.F_m, self._T_s, self._crossover))),
            hold=Hold(float(np.ptp(rest)), reversals(rest, step), len(rest) * self._T_s, unit=unit),
        )
        own = {old.motion: old for old in self.motions if old.loop == PRESENT}
        present = own.get(motion.name, found)
        both = zip(found.errors, present.errors, self._shown, strict=False)
        ratios = [math.hypot(own, least) / math.hypot(old, least) for own, old, least in both]
        found = replace(found, ratios=tuple(ratios))
        self.motions.append(found)
        return self.worse(found, present)

    def worse(self, found: RigMotion, present: RigMotion) -> str:
        """Return why a motion is worse than allowed beside that of the present loop, or nothing."""
        what, F_c = f"{found.loop}, {found.motion}: ", self.learned.friction["F_c"]
        if found.force > max(kept.FORCE * self._peak, present.force):
            return (
                f"{what}the force reaches {found.force:.3g} {self._unit('N')}; expected at most"
                f" {kept.FORCE:g} of {self._peak:.3g}"
            )
        if found.ripple > (limit := max(kept.CHATTER * F_c, rig_tuning.RIPPLE * present.ripple)):
            return (
                f"{what}the force oscillates by {found.ripple:.3g} {self._unit('N')} RMS; expected"
                f" at most {limit:.3g}"
            )
        swing = max(caution.SWING * self.rig.datasheet.encoder_step, present.hold.swing)
        if found.hold.hunts(swing):
            return f"{what}{described(found.hold)}"
        if (ratio := max(found.ratios)) > rig_tuning.WORSE:
            return (
                f"{what}the error is {ratio:.3g} times that of the present loop; expected at most"
                f" {rig_tuning.WORSE:g}"
            )
        return ""

    def trial(self, budget: int, stopped: str) -> RigTrial:
        """Return what the drive showed."""
        rotary = self.start.loop.axis.rotary
        return RigTrial(self.rig.name, tuple(self.motions), budget, stopped, rotary=rotary)

    def _unit(self, unit: str) -> str:
        return self.start.loop.axis.unit(unit)

    def _recording(self, v_cmd: Array, x_enc: Array, force: Array) -> Recording:
        t = np.asarray(np.arange(len(v_cmd)) * self._T_s)
        return Recording(t, x_enc, force, velocity_command=v_cmd)
