"""One command per file: ``declare`` declares its options, ``run`` executes it.

The first line of the file, ``stickslip NAME`` and what it does, makes it a command.
"""

import argparse


def add_old_spelling(parser: argparse.ArgumentParser, old: str, action: argparse.Action) -> None:
    """Accept an option of one value also as ``old``, which the help does not list."""
    parser.add_argument(
        old,
        dest=action.dest,
        choices=action.choices,
        default=argparse.SUPPRESS,
        help=argparse.SUPPRESS,
    )
