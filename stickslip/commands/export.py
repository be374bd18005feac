"""``stickslip export``: the tuned compensator, an observer, a linear system or a whole loop."""

from __future__ import annotations

import argparse

from stickslip.commands import (
    export_compensator,
    export_components,
    export_lti,
    export_observer,
    export_rig,
    export_system,
)


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare what the command exports."""
    exports = parser.add_subparsers(
        dest="what", metavar="compensator|observer|components|lti|rig|FILE.ssp", required=True
    )
    exports.choices = exports._name_parser_map = _Parsers()  # noqa: SLF001 - no public way
    export_compensator.add_to(exports)
    export_observer.add_to(exports)
    export_components.add_to(exports)
    export_lti.add_to(exports)
    export_rig.add_to(exports)
    export_system.add_to(exports)


class _Parsers(dict[str, argparse.ArgumentParser]):
    """Parsers by what they export: a file stands for the one of its kind."""

    def __contains__(self, name: object) -> bool:
        is_file = str(name).endswith(".ssp") and name != export_system.NAME
        return super().__contains__(name) or is_file

    def __missing__(self, name: str) -> argparse.ArgumentParser:
        return self[export_system.NAME]
