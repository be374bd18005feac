"""The files of a reproduction, as its page lists them."""

from __future__ import annotations

from stickslip.papers.lugre.reproduction import Reproduction


def files_of(reproduction: Reproduction) -> dict[str, str]:
    """Return what the files contain."""
    best = reproduction.loops.best.tuned
    files = {
        "learned_loop.ssp": "the learned loop, for any tool that opens SSP: use this one",
        "compensator.fmu, loop.ssp": "the same for the paper's own loop, with the whole force",
        "learned.json": "friction and both loops with units, cost, seed and versions",
        "loop_tuning.csv, fitness.csv": "what each step brings, and the searches",
        "table2.csv, table4.csv": "the tables of this page, unrounded",
    }
    if best.share:
        files["learned_compensator.fmu"] = "its feedforward, from the commands to the force"
    if best.observer.share:
        files["learned_observer.fmu"] = "its observer, from encoder and motor force to the force"
    if reproduction.motions:
        files["motions.csv"] = "errors of all motions, by region"
    if reproduction.extras and reproduction.extras.table4 is not None:
        files["table4_all_extras.csv"] = "Table 4 of the drive with all extras on"
    return files
