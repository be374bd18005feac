"""The folders that a reproduction and the learning as published leave behind."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from stickslip import cosim, models
from stickslip.catalog.parameters import start_unit, unit_of
from stickslip.evaluation.motions import VALIDATION
from stickslip.fmi.process import temporary_folder
from stickslip.learned import writing
from stickslip.papers.lugre.page import FIG5, study_section, write_report
from stickslip.papers.lugre.page import FILES as REPORT
from stickslip.papers.lugre.published import START, TABLES, PublishedStudy
from stickslip.papers.lugre.reproduction import Options, Reproduction
from stickslip.presentation.page import picture_files, write_page
from stickslip.servo.systems import Compensator, build_loop, deployed, for_all_platforms
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.simulation import pack_input
from stickslip.storage import staged
from stickslip.storage.codec import state
from stickslip.storage.writing import write_json, write_tables
from stickslip.tuning.loop_runs import GENES

FMU = "compensator"  # Name of the compensator's model and FMU
LEARNED_LOOP = ("learned_loop.ssp", "learned_compensator.fmu", "learned_observer.fmu")
"""The learned loop, and its feedforward and observer where it has them."""
FILES = (
    *("table2.csv", "table4.csv", "motions.csv", "fitness.csv", "loop_tuning.csv"),
    *("learned.json", "compensator.fmu", "loop.ssp", *LEARNED_LOOP),
    *REPORT,
)
"""What ``write_results`` writes."""
PUBLISHED_TITLE = "The paper’s learning as published"
PUBLISHED_FILES = (*(f"{name}.csv" for name in TABLES), *picture_files([FIG5]), "report.html")
"""What ``write_published_results`` writes."""


def write_results(reproduction: Reproduction, folder: Path) -> None:
    """Write the results as a whole: tables, report, learned.json, compensator.fmu, loop.ssp."""
    loops = reproduction.loops
    with staged(folder, command_of(reproduction.options), without=LEARNED_LOOP) as staging:
        tables = {
            "table2": reproduction.table2(),
            "table4": reproduction.table4(),
            "motions": reproduction.motions.table(),
            "loop_tuning": loops.table,
            "fitness": loops.fitness(),
        }
        write_tables(tables, staging)
        options, loop = reproduction.options, reproduction.identification.loop
        _build(Compensator(FMU, FMU, reproduction.refinement.values), loop, options, staging)
        best = loops.best.tuned
        own = replace(options, law=best.law.name)
        if best.share:
            feedforward, *observers = best.chain()
            _build(feedforward, best.loop, own, staging, f"learned_{FMU}")
            for one in observers:
                name = f"learned_{one.name}"
                models.build_fmu(one.model, staging, start=one.values, called=name)
        write_json(reproduction_document(reproduction), staging / "learned.json")
        write_loop(reproduction.system, loop, staging / "loop.ssp", options)
        system = build_loop(loops.study.rig.fmus, best.loop, best.chain())
        write_loop(system, best.loop, staging / LEARNED_LOOP[0], own)
        write_report(reproduction, staging)


def _build(
    one: Compensator, loop: VelocityLoop, options: Options, folder: Path, called: str = FMU
) -> None:
    """Build the FMU of a feedforward, from the commands of a loop to its force."""
    block = deployed(one, loop, loop.T_s)
    models.build_fmu(block.model, folder, start=block.values, law=options.law, called=called)


def write_published_results(study: PublishedStudy, options: Options, folder: Path) -> None:
    """Write tables, picture and page of the study; raise OSError when a file cannot be written."""
    seeds = len(study.seeds[START])
    with staged(folder, command_of(options, as_published=True, seeds=seeds)) as staging:
        write_tables(study.tables(), staging)
        write_page(staging, PUBLISHED_TITLE, [study_section(study)])


def command_of(options: Options, **more: object) -> dict[str, object]:
    """Return what the manifest says of a reproduction."""
    return {
        "name": "reproduce",
        "set": {f"drive.{name}": value for name, value in options.truth.items()},
        "seed": options.seed,
        "preset": options.preset,
        **({} if options.law == "lugre" else {"law": options.law}),
        **more,
    }


def write_loop(system: cosim.System, loop: VelocityLoop, path: Path, options: Options) -> None:
    """Write the loop of Fig. 2a for all platforms, with the trapezoid as its input."""
    corners = VALIDATION.corners()
    t = np.arange(round((corners[-1] + VALIDATION.begin) / loop.T_s) + 1) * loop.T_s
    stop = float(t[-1])
    experiment = cosim.DefaultExperiment(start=0.0, stop=stop, step=loop.T_s)
    with temporary_folder() as folder:
        whole = for_all_platforms(system, folder, options.truth, options.law)
        cosim.write_ssp(whole, path, experiment)
    table = pd.DataFrame({"time": corners, "v_cmd": VALIDATION.sample(corners)})
    if loop.m_ff:
        table = pd.DataFrame({"time": t, **loop.commands(VALIDATION.sample(np.asarray(t)))})
    pack_input(path, table)


def reproduction_document(reproduction: Reproduction) -> dict[str, Any]:
    """Return the content of learned.json as plain data, values in SI units."""
    learned, options = reproduction.refinement, reproduction.options
    return {
        "schema": writing.SCHEMA,
        "parameters": state(learned.estimates, unit_of),
        "result": learned.chosen,
        "slow_motions": learned.remark or None,
        "cost": {"value": learned.cost, "unit": "m2/s2"},
        "cost_without_compensation": {"value": reproduction.cost_without, "unit": "m2/s2"},
        "runs": learned.runs,
        "seed": options.seed,
        "preset": options.preset,
        "loop": writing.loop_document(reproduction.identification.loop),
        "loop_learning": _loop_learning_entry(reproduction),
        "validation": writing.validation_document(VALIDATION),
        **writing.law_entry(reproduction.identification.law),
        "versions": writing.versions(),
    }


def _loop_learning_entry(reproduction: Reproduction) -> dict[str, Any]:
    """Return the loop that was learned, and the compensators in it."""
    best = reproduction.loops.best
    found = {
        "chosen": best.chosen,
        "seed": best.seed,
        "cost": {"value": best.cost, "unit": "1"},
        "peak_sensitivity": {"value": best.Ms, "unit": "1"},
        "evaluations": best.evaluations,
        "runs": best.runs,
        "models": [
            {
                **_friction_entry(model.law, model.friction),
                "mismatch": {"value": model.mismatch, "unit": "1"},
                "noise_x": {"value": model.noise, "unit": "m"},
            }
            for model in reproduction.loops.study.models  # on which candidates ran
        ],
        "genes": state(best.genes, {g.name: g.unit for g in GENES}),
        "loop": writing.loop_document(best.tuned.loop),
        "share": {"value": best.tuned.share, "unit": "1"},
        "feedforward": _friction_entry(best.tuned.law.name, best.tuned.friction),
    }
    return found | {
        one.name: writing.component_entry(one, rotary=False) for one in best.tuned.chain()[1:]
    }


def _friction_entry(law: str, friction: Mapping[str, float]) -> dict[str, Any]:
    return {"law": law, "parameters": state(friction, start_unit)}
