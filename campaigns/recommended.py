"""What ``stickslip learn --compensator auto`` writes, tried on the drives that made the logs.

    python -m campaigns.recommended --drives lugre gms --out recommended

Each drive is recorded with noise along the planned experiment. The compensators that ``learn``
writes by default, with ``auto``, and with ``auto`` for a controller without motor force then run in
its loop. A row has the ratio of the RMS of v - v_cmd to that without compensation, on each command.
"""

import argparse
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from campaigns.fault_matrix.drives import Drive
from campaigns.fault_matrix.recordings import SOUND, record
from campaigns.never_worse import CLOSE, commands
from campaigns.never_worse import Drive as Commanded
from stickslip.cosim import Simulation
from stickslip.fmi.process import temporary_folder
from stickslip.identification.estimation import LearnSettings
from stickslip.logs import aligned, read_and_check, samples_late
from stickslip.servo.systems import Compensator, build_fmus, build_loop
from stickslip.studies.learn import tables
from stickslip.studies.learn.learned import LearnedFromRecording, learn_recording
from stickslip.studies.learn.log_learning import with_trial
from stickslip.trial.compensator_trial import loops_of_log
from stickslip.trial.observed import BOTH, FEEDFORWARD, OBSERVER

LIGHT = {"m": 0.8, "F_c": 1.5, "F_s": 2.4, "v_s": 2e-3, "sigma_0": 1e5, "sigma_1": 300.0}
DRIVES = {
    **{law: Drive(law) for law in ("lugre", "dahl", "gms", "coulomb_stribeck")},
    **{law: Drive(law) for law in ("elasto_plastic", "leuven")},
    "lugre, 0.8 kg": Drive(parameters=LIGHT),
    "lugre, along the guide": Drive(
        parameters={"position_dependent": True, "position_amplitude": 0.15}
    ),
}
WAYS = {
    "default": {},
    "auto": {"compensator": "auto"},
    "auto, no motor force": {"compensator": "auto", "absent": ("motor_force",)},
}
LEVELS = (0.7, 1.0, 1.3)
"""Friction of the drive afterwards, relative to that at the log."""
RUNS = 3, 48
"""Runs over which an error is averaged, and where the ratio of two is close to 1."""


def main() -> None:
    """Record, learn, try, and print a row for each drive, level and way."""
    parser = argparse.ArgumentParser(prog="python -m campaigns.recommended", description=__doc__)
    parser.add_argument("--drives", nargs="+", choices=DRIVES, default=list(DRIVES))
    parser.add_argument("--law", default="lugre", help="learned, or auto")
    parser.add_argument("--out", type=Path, default=Path("recommended"), metavar="DIR")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, object]] = []
    for name in options.drives:
        rows += tried(name, DRIVES[name], options.law, options.out)
        pd.DataFrame(rows).to_csv(options.out / "recommended.csv", index=False)


def tried(name: str, drive: Drive, law: str, out: Path) -> Iterator[dict[str, object]]:
    """Yield a row for each way and level of friction."""
    with temporary_folder() as folder:
        build_fmus(folder, {"law": drive.law, **drive.parameters})
        log, description = record(folder, drive, SOUND, seed=0)
        path = out / "log.csv"
        log.to_csv(path, index=False)
        reading, findings = read_and_check(path, description)
        recording = aligned(reading.recording, samples_late(reading.recording))
        reading = replace(reading, recording=recording)
        settings = LearnSettings(law=law)
        gains, design = reading.controller.parameters(), partial(loops_of_log, reading)
        learned = learn_recording(recording, gains, design, findings, settings)
    for way, asked in WAYS.items():
        begin = time.process_time()
        one = with_trial(reading, learned, LearnSettings(**asked))
        seconds = time.process_time() - begin
        compared = one.trial.compared if one.trial else None
        chosen = compared.chosen.name if compared else one.writes()
        family = one.trial.benefit.mean_ratio if one.trial else np.nan
        if compared:
            family = compared.chosen.mean
        elif one.trial and one.trial.observed:
            family = {p: b.mean_ratio for p, b in one.trial.observed.parts.items()}.get(
                one.writes(), 1.0
            )
        if compared and way == "auto":
            print(tables.compensators(compared).frame().round(3).to_string(index=False), flush=True)
        ratios = on_drive(drive, written(one), one.estimation.law.name)
        for level, of in ratios.items():
            mean = float(np.exp(np.mean(np.log(list(of.values())))))
            row = {"drive": name, "way": way, "chosen": chosen, "family": family, "level": level}
            yield {**row, "mean": mean, "worst": max(of.values()), **of, "cpu": seconds}
            print(
                f"{name:24} {way:22} {chosen:24} family {family:.3f} friction x {level:g}: mean "
                f"{mean:.3f} worst {max(of.values()):.3f} {seconds:.1f} s",
                flush=True,
            )


def written(learned: LearnedFromRecording) -> list[Compensator]:
    """Return the compensators that ``learn`` writes."""
    what = learned.writes()
    found = [learned.feedforward] if what in (FEEDFORWARD, BOTH) else []
    return found + ([learned.observer] if learned.observer and what in (OBSERVER, BOTH) else [])


def on_drive(
    drive: Drive, chain: Sequence[Compensator], law: str
) -> dict[float, Mapping[str, float]]:
    """Return the ratios of the errors with and without compensators by level and command."""
    of_length = {name: drive.start[name] for name in ("F_c", "sigma_0") if name in drive.start}
    given = dict(commands(Commanded("", of_length)))
    until = (max(map(len, given.values())) - 1) * drive.loop.T_s
    with temporary_folder() as folder, ExitStack() as stack:
        build_fmus(folder, {"law": drive.law, **drive.parameters}, law)
        without, compensated = (
            stack.enter_context(
                build_loop(folder, drive.loop, one).prepare(
                    step=drive.loop.T_s, stop=until, record=("drive.v",)
                )
            )
            for one in ([], chain)
        )

        def ratio(v_cmd: np.ndarray, level: float) -> float:
            for runs in RUNS:
                errors = [_error(drive, one, v_cmd, level, runs) for one in (compensated, without)]
                if not CLOSE[0] < errors[0] / errors[1] < CLOSE[1]:
                    break
            return errors[0] / errors[1]

        return {
            level: {name: ratio(v_cmd, level) for name, v_cmd in given.items()} for level in LEVELS
        }


def _error(
    drive: Drive, simulation: Simulation, v_cmd: np.ndarray, level: float, runs: int
) -> float:
    """Return the RMS of v - v_cmd [m/s] over friction within 1 % and several seeds of the noise."""
    loop, squares = drive.loop, []
    longer = np.pad(v_cmd, (0, len(simulation.time) - len(v_cmd)), mode="edge")
    until = (len(v_cmd) - 1) * loop.T_s
    for seed, by in enumerate(np.linspace(0.99, 1.01, runs)):
        values = {"drive.noise": True, "drive.seed": seed, **drive.at(by * level)}
        v = simulation.run(values, loop.commands(longer), until=until)["drive.v"]
        squares.append(np.mean((v[: len(v_cmd)] - v_cmd) ** 2))
    return float(np.sqrt(np.mean(squares)))


if __name__ == "__main__":
    main()
