"""``stickslip export observer``: the designed disturbance observer as FMU, C or structured text."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from stickslip import models
from stickslip.commands import FLAG, add_options, warn
from stickslip.commands.export_compensator import add_form_option
from stickslip.commands.platforms import add_fmu_options, fmu_options
from stickslip.errors import HarmfulError, UsageError
from stickslip.models.firmware import write_compensator
from stickslip.output import Answer
from stickslip.results.learned import LearnedFile
from stickslip.servo.observer import LIMIT
from stickslip.servo.sensitivity import peak_sensitivity

NAME = "observer"


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser(NAME, help="the disturbance observer: FMU, C or PLC code")
    parameters = {"--parameters FILE.json": "a learned.json with an observer"}
    add_options(parser, parameters, type=Path, required=True)
    add_form_option(parser)
    force = "export it even if learn refused it or the loop is not robust with it"
    add_options(parser, {"--force": force}, **FLAG)
    add_fmu_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Write the observer with its designed gains and print the paths.

    Raises
    ------
    HarmfulError
        When learning refused it, or the peak sensitivity of the loop is too large with it.
    """
    learned = LearnedFile(options.parameters)
    start = learned.observer.parameters()
    for refusal in _refusals(learned):
        if not options.force:
            raise HarmfulError(f"{options.parameters}: {refusal}; --force exports it anyway")
        warn(refusal)
    try:
        if options.form == "fmu":
            further = fmu_options(options)
            paths = [models.build_fmu("dob", options.out, start=start, called=NAME, **further)]
        else:
            paths = write_compensator(
                options.out, options.form, start=start, model="dob", called=NAME
            )
    except models.StartValueError as error:
        raise UsageError(f"{options.parameters}: observer: {error}") from None
    print(*paths, sep="\n")
    return Answer({"written": paths})


def _refusals(learned: LearnedFile) -> list[str]:
    found = []
    if learned.observer_refusal:
        found.append(f"learn does not recommend the observer: {learned.observer_refusal}")
    if learned.loop is not None:
        peak = peak_sensitivity(learned.loop, learned.observer)
        if not peak <= LIMIT:
            found.append(
                f"with the observer the loop has a peak sensitivity of {peak:.3g}; expected at "
                f"most {LIMIT:g}"
            )
    return found
