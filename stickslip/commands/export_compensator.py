"""``stickslip export compensator``, ``observer``, ``position_force``, ``deploy``: FMU or code."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.commandline import FLAG, add_options, warn, written
from stickslip.commandline.platforms import add_fmu_options, fmu_options
from stickslip.errors import HarmfulError, UsageError
from stickslip.fmi.process import temporary_folder
from stickslip.output import Answer
from stickslip.thresholds import offer

if TYPE_CHECKING:
    from stickslip.learned.file import LearnedFile
    from stickslip.servo.systems import Compensator
    from stickslip.servo.velocity_loop import VelocityLoop

NAME = "compensator"  # of the command, of what it writes, and of the model that evaluates any law
MOST_SAMPLES = 10_000_000  # of a validation command


def add_compensators(exports: argparse._SubParsersAction[Any]) -> None:
    """Declare the commands."""
    forms = "FMU, C or PLC code"
    _add(
        *(exports, NAME, export_compensator, f"the tuned compensator: {forms}"),
        parameters="parameters of the compensator: a learned.json",
        force="export the whole force, even if it makes the loop worse",
    )
    _add(
        *(exports, "observer", export_observer, f"the disturbance observer: {forms}"),
        parameters="a learned.json with an observer",
        force="export it even if learn refused it or the loop is not robust with it",
    )
    _add(
        *(exports, "position_force", export_position_force, f"what holds gravity: {forms}"),
        parameters="a learned.json with a force of position",
        force="export it even if learn refused the values",
    )
    parser = exports.add_parser("deploy", help="all that learn wrote, as code behind one call")
    deployed = "a learned.json; what it says was written is exported as it is"
    add_options(parser, {"--parameters FILE.json": deployed}, type=Path, required=True)
    out = {"--out DIR": "folder to write into (default deploy)"}
    add_options(parser, out, type=Path, default=Path("deploy"))
    parser.set_defaults(run=export_deployment)


def _add(
    exports: argparse._SubParsersAction[Any],
    name: str,
    run: Callable[[argparse.Namespace], Answer],
    text: str,
    parameters: str,
    force: str,
) -> None:
    parser = exports.add_parser(name, help=text)
    add_options(parser, {"--parameters FILE.json": parameters}, type=Path, required=True)
    form = (
        "an FMU (default), C99 for firmware, or structured text for a PLC, as text or PLCopen XML"
    )
    forms = ["fmu", "c", "st", "plcopen"]
    parser.add_argument("--as", dest="form", choices=forms, default="fmu", help=form)
    add_options(parser, {"--force": force}, **FLAG)
    add_fmu_options(parser)
    parser.set_defaults(run=run)


def export_compensator(options: argparse.Namespace) -> Answer:
    """Write the compensator with its learned start values and print the paths.

    Warnings go to standard error. The force is reduced to the largest share that makes the loop
    worse nowhere; where there is none, nothing is written.
    """
    from stickslip import models
    from stickslip.learned.file import LearnedFile

    learned = LearnedFile(options.parameters)
    one = learned.at(1.0 if options.force else learned.share)
    law = (one.law or learned.law.name) if one.model == NAME else None
    try:
        models.load_model(one.model, law).with_start(one.values)
        share = _guarded_share(learned, one, force=options.force)
        block = learned.deployed(share)
        given = {"start": block.values, "law": law}
        paths = write_as(options, learned, block.model, NAME, share=share, **given)
    except models.StartValueError as error:
        raise UsageError(f"{options.parameters}: {error}") from None
    return written(*paths)


def _guarded_share(learned: LearnedFile, one: Compensator, *, force: bool) -> float:
    """Try a compensator, print what is found, and return the share of the whole force to export.

    Raises HarmfulError when it makes the loop worse at every share, was never tried, or learning
    refused it, and is not forced.
    """
    from stickslip.studies.learn.tables import benefit_text
    from stickslip.trial.benefit import NONE, Variant
    from stickslip.trial.hold import holds, hunting_at_rest

    path, loop = learned.path, learned.loop
    refusal = f"learn refused it: {learned.refusal}" if learned.refusal else ""
    if loop is None and not learned.document.get("tracking_error"):
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
    variant = Variant("feedforward", (one,))
    with learned.bench(loop) as bench:
        (benefit,) = bench.benefits([variant], shares=(1.0,))
        if not benefit.acceptable:
            (benefit,) = bench.benefits([variant])
        if loop.K_x:
            shared = variant.share(bench.law, 1.0 if force else benefit.share)
            held = holds(bench, [NONE, shared])
            for warning in hunting_at_rest(held, shared, bench.datasheet.encoder_step):
                warn(warning)
    if not benefit.acceptable:
        print(benefit_text(benefit, "the compensator"), file=sys.stderr)
        if not force:
            raise HarmfulError(f"{path}: {benefit.refusal}; --force exports it anyway")
        warn(benefit.refusal)
    elif benefit.share < 1.0:
        share = share if force else share * benefit.share
        fate = "the whole force" if force else f"{share:g} of the force"
        warn(f"{fate} is exported: {benefit.reason}")
    return share


def write_as(
    options: argparse.Namespace,
    learned: LearnedFile,
    model: str,
    called: str,
    share: float | None = None,  # of a feedforward
    **given: Any,  # of ``models.build_fmu``
) -> list[Path]:
    """Write a compensator in the form that is wanted."""
    from stickslip import models
    from stickslip.learned.provenance import provenance
    from stickslip.models.firmware import write_compensator

    given |= {"called": called, "rotary": learned.rotary}
    end = "xml" if options.form == "plcopen" else options.form
    given["notes"] = provenance(learned, share, f"{called}.{end}")
    if options.form == "fmu":
        return [models.build_fmu(model, options.out, **given, **fmu_options(options))]
    return write_compensator(options.out, options.form, model=model, **given)


def export_observer(options: argparse.Namespace) -> Answer:
    """Write the observer with its designed gains and print the paths."""
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
        paths = write_as(options, learned, model, "observer", start=start)
    except models.StartValueError as error:
        raise UsageError(f"{options.parameters}: observer: {error}") from None
    return written(*paths)


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


def export_position_force(options: argparse.Namespace) -> Answer:
    """Write the block of gravity and cogging with its learned values and print the paths."""
    from stickslip.learned.file import LearnedFile

    learned = LearnedFile(options.parameters)
    block = learned.position_force
    if block is None:
        raise UsageError(f"{options.parameters}: contains no force of position")
    if "position_force.fmu" not in learned.written and not options.force:
        refusal = learned.refusal or "learn did not write it"
        raise HarmfulError(f"{options.parameters}: {refusal}; --force exports it anyway")
    return written(*write_as(options, learned, block.model, block.name, start=block.values))


def export_deployment(options: argparse.Namespace) -> Answer:
    """Write all blocks behind one call and the page of steps, and print the paths."""
    from stickslip.learned.deploying import write_deployment
    from stickslip.learned.file import LearnedFile

    return written(*write_deployment(LearnedFile(options.parameters), options.out))
