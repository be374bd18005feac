"""``stickslip NEW_NAME``: greet a drive."""

import argparse

from stickslip.output import Answer


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("drive")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Print the greeting."""
    print(f"hello, {options.drive}")
    return Answer({"greeted": options.drive})
