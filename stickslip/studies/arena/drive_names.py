"""Names of the default drives, known before anything is imported that designs or simulates them."""

from collections.abc import Iterable, Sequence
from importlib.resources import files
from typing import Any

from stickslip import models
from stickslip.errors import UsageError
from stickslip.fmi.files import parse_toml
from stickslip.fmi.messages import suggestion


def content() -> dict[str, Any]:
    """Return ``drives.toml``: ``measurement``, and a table for each drive."""
    return parse_toml(files(__package__).joinpath("drives.toml").read_bytes())


def drive_names() -> list[str]:
    """Return the names of the default drives: those of ``drives.toml``, and of laws without one."""
    tables = content()
    del tables["measurement"]
    shown = {table["law"] for table in tables.values()}
    return [*tables, *(law for law in models.law_names() if law not in shown)]


def require_drives(wanted: Iterable[str], known: Sequence[str]) -> None:
    """Raise UsageError where a drive that is wanted is not among those that are known."""
    for name in wanted:
        if name not in known:
            raise UsageError(f"there is no drive '{name}'{suggestion(name, known)}")
