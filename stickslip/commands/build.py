"""``stickslip build``: build FMUs of the models.

stickslip build --out fmus
stickslip build drive --of emps --fmi 3 --out fmus
"""

import argparse
import itertools
import os
from pathlib import Path
from typing import Any

from stickslip import models
from stickslip.commandline import FLAG, add_options, complete_with
from stickslip.commandline.platforms import add_platform_option
from stickslip.errors import UsageError
from stickslip.fmi.process import Threads
from stickslip.output import Answer

VERSIONS: tuple[models.FmiVersion, ...] = (2, 3)


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    named = parser.add_argument("models", nargs="*", metavar="MODEL", help="all by default")
    complete_with(named, models.model_names)
    parser.add_argument("--fmi", choices=["2", "3", "both"], default="both")
    laws = ", ".join(models.law_names())
    add_options(parser, {"--law NAME": f"friction law of the models that contain one: {laws}"})
    add_options(parser, {"--of NAME": "a published drive, see docs/drives.md; builds drive"})
    add_platform_option(parser)
    terminals = "FMI 2.0 without terminals, of which FMI Library says FATAL"
    add_options(parser, {"--no-terminals": terminals}, **FLAG)
    parser.add_argument("--out", type=Path, default=Path("fmus"), metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Build and print the paths: DIR/NAME.fmu, or DIR/fmi2 and DIR/fmi3 for both versions."""
    versions = [version for version in VERSIONS if options.fmi in (str(version), "both")]
    names = options.models or [
        name for name in models.model_names() if not options.law or models.load_model(name).law
    ]
    given: dict[str, Any] = {"law": options.law}
    if options.of:
        given, names = _published(options), ["drive"]
    for name in names:  # an unknown one must not leave half of the files
        try:
            models.load_model(name, given["law"])
        except models.UnknownModel:
            raise_if_compensator(name)
            raise
    folders = {v: options.out / f"fmi{v}" if len(versions) > 1 else options.out for v in versions}

    def build(job: tuple[str, models.FmiVersion]) -> Path:
        name, version = job
        return models.build_fmu(
            name,
            folders[version],
            fmi=version,
            platforms=options.platform,
            terminals=version == 3 or not options.no_terminals,
            **given,
        )

    written = []
    with Threads(os.cpu_count()) as pool:
        for path in pool.each(build, itertools.product(names, versions)):
            print(path)
            written.append(path)
    return Answer({"written": written})


def raise_if_compensator(name: str) -> None:
    """Raise UsageError with the model of a compensator that has another name than it."""
    from stickslip.compensators.entrants import parts

    one = parts().get(name)
    if one is not None and one.model:
        law = f" --law {name}" if name in models.law_names() else ""
        said = f"the compensator '{name}' is the model {one.model} with values of its own"
        raise UsageError(f"{said}: stickslip build {one.model}{law}; see docs/compensators.md")


def _published(options: argparse.Namespace) -> dict[str, Any]:
    """Return law, motion and start values of the drive of ``--of``."""
    from stickslip.drives.published import drive  # late: loads what runs systems

    one = drive(options.of)
    if options.law or options.models not in ([], ["drive"]):
        raise UsageError(
            f"--of {options.of}: expected the model drive and no --law, for the law is"
            f" {one.law.name}; got {' '.join(options.models)} {options.law or ''}".rstrip()
        )
    return {"law": one.law.name, "rotary": one.rotary, "start": one.start}
