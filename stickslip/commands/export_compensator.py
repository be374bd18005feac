"""``stickslip export compensator``: the tuned compensator as FMU, C or structured text."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.commandline import FLAG, add_options, warn
from stickslip.commandline.platforms import add_fmu_options, fmu_options
from stickslip.errors import HarmfulError, UsageError
from stickslip.output import Answer

if TYPE_CHECKING:
    from stickslip.learned.file import LearnedFile
    from stickslip.servo.systems import Compensator


NAME = "compensator"  # of the command, of what it writes, and of the model that evaluates any law
MOST_SAMPLES = 10_000_000  # of a validation command


def add_to(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the command."""
    parser = exports.add_parser(NAME, help="the tuned compensator: FMU, C or PLC code")
    parameters = {"--parameters FILE.json": "parameters of the compensator: a learned.json"}
    add_options(parser, parameters, type=Path, required=True)
    add_form_option(parser)
    force = "export the whole force, even if it makes the loop worse"
    add_options(parser, {"--force": force}, **FLAG)
    add_fmu_options(parser)
    parser.set_defaults(run=run)


def add_form_option(parser: argparse.ArgumentParser) -> None:
    """Declare ``--as``."""
    parser.add_argument(
        "--as",
        dest="form",
        choices=["fmu", "c", "st"],
        default="fmu",
        help="an FMU (default), C99 for firmware, or IEC 61131-3 structured text for a PLC",
    )


def run(options: argparse.Namespace) -> Answer:
    """Write the compensator with its learned start values and print the paths.

    What the guards find goes to standard error. The force is reduced to the largest share that
    makes the loop worse nowhere; where there is none, nothing is written.
    """
    from stickslip import models
    from stickslip.learned.file import LearnedFile

    learned = LearnedFile(options.parameters)
    one = learned.at(1.0 if options.force else learned.share)
    law = learned.law.name if one.model == NAME else None
    try:
        models.load_model(one.model, law).with_start(one.values)
        block = learned.deployed(_guarded_share(learned, one, force=options.force))
        named = {"called": NAME, "rotary": learned.rotary}
        paths = write_as(options, block.model, start=block.values, law=law, **named)
    except models.StartValueError as error:
        raise UsageError(f"{options.parameters}: {error}") from None
    print(*paths, sep="\n")
    return Answer({"written": paths})


def _guarded_share(learned: LearnedFile, one: Compensator, *, force: bool) -> float:
    """Try a compensator, print what is found, and return the share of the whole force to export.

    Raises HarmfulError when it makes the loop worse at every share, was never tried, or learning
    refused it, and is not forced.
    """
    from stickslip.studies.learn.terminal import print_benefit
    from stickslip.trial.guards import bench_of, benefits_on_drives, feedforward

    path, loop = learned.path, learned.loop
    refusal = f"learn refused it: {learned.refusal}" if learned.refusal else ""
    if loop is None and not learned.is_tried:
        refusal = refusal or "it contains neither a loop to try this compensator in nor a trial"
    if refusal and not force:
        raise HarmfulError(f"{path}: {refusal}; --force exports it anyway")
    if refusal:
        warn(f"{path}: {refusal}; exported, as --force asks for")
    share = learned.share
    if force and share < 1.0:
        warn(f"{path}: the whole force is exported, as --force asks for, not {share:g} of it")
        share = 1.0
    if loop is None:
        warn(
            f"{path} contains no loop: the force is that of the velocity command, which comes early"
        )
        return share
    command = learned.validation
    duration = command.corners()[-1] + command.begin
    if duration > MOST_SAMPLES * loop.T_s:
        raise UsageError(
            f"{path}: validation: {duration:g} s with a sample every {loop.T_s:g} s; expected at "
            f"most {MOST_SAMPLES} samples"
        )
    friction, variants = learned.friction, [feedforward(one.values, model=one.model)]
    with bench_of(
        learned.law,
        loop,
        friction,
        learned.drives,
        command=command,
        datasheet=learned.datasheet,
        feed=learned.feed,
    ) as bench:
        (benefit,), found = benefits_on_drives(
            bench, friction, variants, learned.standard_errors, force=force
        )
    for finding in found:
        warn(str(finding))
    if not benefit.acceptable:
        print_benefit(benefit, sys.stderr)
        if not force:
            raise HarmfulError(f"{path}: {benefit.refusal}; --force exports it anyway")
        warn(benefit.refusal)
    elif benefit.share < 1.0:
        share = share if force else share * benefit.share
        fate = "the whole force" if force else f"{share:g} of the force"
        warn(f"{fate} is exported: {benefit.reason}")
    return share


def write_as(options: argparse.Namespace, model: str, **given: Any) -> list[Path]:
    """Write a compensator in the form that is wanted; ``given`` is that of ``models.build_fmu``."""
    from stickslip import models
    from stickslip.models.firmware import write_compensator

    if options.form != "fmu":
        return write_compensator(options.out, options.form, model=model, **given)
    return [models.build_fmu(model, options.out, **given, **fmu_options(options))]
