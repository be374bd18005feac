"""Names of what competes, known before anything is imported that designs or simulates it."""

from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from typing import Any

from stickslip import models
from stickslip.errors import UsageError
from stickslip.fmi.files import parse_toml
from stickslip.fmi.messages import suggestion


@cache
def content() -> dict[str, Any]:
    """Return ``entrants.toml``: a table for each part, and lists of names."""
    return parse_toml(files(__package__).joinpath("entrants.toml").read_bytes())


@cache
def part_names() -> tuple[str, ...]:
    """Return the names of all parts: those of ``entrants.toml``, then what enters without one."""
    tables = {name: table for name, table in content().items() if isinstance(table, dict)}
    used = {table.get("model") for table in tables.values()} | {"compensator"}
    blocks = (name for name in models.model_names() if name not in used)
    added = (name for name in blocks if models.load_model(name).ports is not None)
    return tuple(dict.fromkeys([*tables, *models.law_names(), *added]))


def require_parts(name: str, further: Iterable[str] = ()) -> None:
    """Raise UsageError where a part, such as ``ekbf`` of ``dahl+ekbf``, is unknown."""
    known = {*part_names(), *further}
    for word in name.split("+"):
        if word not in known:
            there = [*part_names(), *further]
            raise UsageError(f"compensator '{name}': there is no '{word}'{suggestion(word, there)}")
