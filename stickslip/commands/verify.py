"""``stickslip verify``: check folders of results against their manifests.

stickslip verify axis
stickslip verify results/paper --without "*.fmu"
"""

import argparse
from pathlib import Path

from stickslip.commandline import SEVERAL, add_options
from stickslip.output import LOG, Answer
from stickslip.storage import verify


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Compare the files of a folder with the hashes in its manifest.json, and name "
        "each that is missing, changed or additional. New results that a killed process left "
        "complete but not all in place are moved in first."
    )
    parser.epilog = "status 0: all files are as written; 1: some are not; 2: usage"
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR")
    missing = {"--without PATTERN": "files that are not compared, such as '*.fmu' in a repository"}
    add_options(parser, missing, **SEVERAL)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Print a line for each file that is not as it was written."""
    bad, document = [], {}
    for folder in options.folders:
        verdict = verify(folder, options.without)
        document[str(folder)] = {"faults": verdict.faults, "notes": verdict.notes}
        for name, fault in (*verdict.notes.items(), *verdict.faults.items()):
            shown = name if name.isprintable() else repr(name)
            print(f"{folder / shown}: {fault}")
        if verdict.faults:
            bad.append(f"{folder}: {verdict}")
        else:
            print(f"{folder}: {verdict}")
    if bad:
        LOG.error("%s", "; ".join(bad))
    return Answer(document, 1 if bad else 0)
