"""Hostile inputs of every kind, what we make of them and what FMPy does."""

from tests.corpus.hostile import (
    archives,
    binaries,
    descriptions,
    folders,
    learning,
    statuses,
    systems,
    tables,
    xml,
)
from tests.corpus.hostile.case import GROUPS, Case

CASES: list[Case] = [
    *archives.CASES,
    *xml.CASES,
    *descriptions.CASES,
    *binaries.CASES,
    *statuses.CASES,
    *systems.CASES,
    *tables.CASES,
    *learning.CASES,
    *folders.CASES,
]
"""All of them, group by group."""

__all__ = ["CASES", "GROUPS", "Case"]
