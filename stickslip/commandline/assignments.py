"""``--set`` and ``--law`` on the command line."""

from argparse import ArgumentParser, _ActionsContainer
from collections.abc import Collection, Iterable

from stickslip.commandline import SEVERAL, add_options
from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion

_WORDS = {"true": 1.0, "on": 1.0, "false": 0.0, "off": 0.0}


def add_set_option(parser: ArgumentParser, what: str = "") -> None:
    """Declare ``--set``, of the simulated drive where nothing else is given."""
    what = what or "parameters of the simulated drive: drive.NAME=VALUE, drive.law=NAME"
    add_options(parser, {"--set NAME=VALUE": what}, **SEVERAL)


def add_law_option(parser: _ActionsContainer, *further: str, more: str = "") -> None:
    """Declare ``--law``, the friction law; the first of the further choices is the default."""
    from stickslip.catalog.parameters import learnable_laws
    from stickslip.models import law_names

    default, *_ = *further, "lugre"
    parser.add_argument(
        "--law",
        choices=[*law_names(), *further],  # the others are refused with the reason
        metavar=f"{{{','.join([*learnable_laws(), *further])}}}",
        default=default,
        help=f"friction law of the compensator (default {default}){more}",
    )


def split_assignments(
    texts: Iterable[str], option: str = "--set", known: Collection[str] = ()
) -> dict[str, str]:
    """Return name -> value as it was written.

    Raises UsageError when a text is not an assignment, or a name is unknown or comes twice.
    Messages name the option. Where ``known`` is empty any name is accepted.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, _, value = (part.strip() for part in text.partition("="))
        if not (name and value):
            raise UsageError(f"{option} {text}: expected NAME=VALUE")
        if known and name not in known:
            raise UsageError(f"{option} {text}: no '{name}'{suggestion(name, known)}")
        if name in values:
            raise UsageError(f"{option} {text}: {name} is set twice")
        values[name] = value
    return values


def drive_changes(texts: Iterable[str]) -> dict[str, float | str]:
    """Return the assignments to ``drive.NAME`` by NAME, all numbers but ``law``; or raise."""
    changes: dict[str, float | str] = {}
    for name, value in split_assignments(texts).items():
        if name == "drive.law":
            changes["law"] = value
            continue
        if not name.startswith("drive."):
            raise UsageError(f"--set {name}: only the drive's parameters can be set, as drive.NAME")
        changes[name.removeprefix("drive.")] = _number("--set", name, value)
    return changes


def _number(option: str, name: str, value: str) -> float:
    try:
        # 1_000 is a number to Python alone
        return _WORDS[value.lower()] if value.lower() in _WORDS else float(value.replace("_", "?"))
    except ValueError:
        raise UsageError(
            f"{option} {name}={value}: the value must be a number, true or false"
        ) from None
