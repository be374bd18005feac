"""``stickslip export observer``: the designed disturbance observer as FMU, C or structured text."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.commandline import FLAG, add_options, warn
from stickslip.commandline.platforms import add_fmu_options
from stickslip.commands.export_compensator import add_form_option, write_as
from stickslip.errors import HarmfulError, UsageError
from stickslip.fmi.process import temporary_folder
from stickslip.output import Answer
from stickslip.thresholds import offer

if TYPE_CHECKING:
    from stickslip.learned.file import LearnedFile
    from stickslip.servo.systems import Compensator
    from stickslip.servo.velocity_loop import VelocityLoop


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

    Raises HarmfulError when learning refused it, or the peak sensitivity of the loop is too large
    with it.
    """
    from stickslip import models
    from stickslip.learned.file import LearnedFile

    learned = LearnedFile(options.parameters)
    observer = learned.observer
    model, start = observer.model, observer.values
    try:
        models.load_model(model).with_start(start)
        for refusal in _refusals(learned, observer):
            if not options.force:
                raise HarmfulError(f"{options.parameters}: {refusal}; --force exports it anyway")
            warn(refusal)
        paths = write_as(options, model, start=start, called=NAME, rotary=learned.rotary)
    except models.StartValueError as error:
        raise UsageError(f"{options.parameters}: observer: {error}") from None
    print(*paths, sep="\n")
    return Answer({"written": paths})


def _refusals(learned: LearnedFile, observer: Compensator) -> list[str]:

    found = []
    if learned.observer_refusal:
        found.append(f"learn does not recommend the observer: {learned.observer_refusal}")
    if learned.loop is not None:
        peak = _peak(learned.loop, observer, learned.validation.height)
        if not peak <= offer.SENSITIVITY:
            found.append(
                f"with the observer the loop has a peak sensitivity of {peak:.3g}; expected at "
                f"most {offer.SENSITIVITY:g}"
            )
    return found


def _peak(loop: VelocityLoop, observer: Compensator, speed: float) -> float:
    """Return the peak sensitivity of a loop with an observer, measured on its FMU."""
    from stickslip import models
    from stickslip.servo.chain_response import ChainResponse

    with temporary_folder() as folder:
        models.build_fmu(observer.model, folder)
        with ChainResponse(folder, loop, [observer], abs(speed)) as response:
            return response.of(loop, {}, friction=0.0).peak
