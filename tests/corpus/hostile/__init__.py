"""Hostile inputs of every kind, what we make of them and what FMPy does."""

from importlib import import_module

from tests.corpus.hostile.case import GROUPS, Case

_MODULES = (
    *("archives", "xml", "descriptions", "binaries", "statuses", "systems", "tables", "learning"),
    *("folders", "rigs", "arena", "arguments", "options", "exports", "clusters"),
)
CASES: list[Case] = [
    case for name in _MODULES for case in import_module(f"{__name__}.{name}").CASES
]
"""All of them, group by group."""

__all__ = ["CASES", "GROUPS", "Case"]
