"""Hostile inputs of every kind, what we make of them and what FMPy does."""

from tests.corpus.hostile import (
    archives,
    arena,
    arguments,
    binaries,
    clusters,
    descriptions,
    exports,
    folders,
    learning,
    options,
    rigs,
    sandboxed,
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
    *rigs.CASES,
    *arena.CASES,
    *arguments.CASES,
    *options.CASES,
    *exports.CASES,
    *sandboxed.CASES,
    *clusters.CASES,
]
"""All of them, group by group."""

__all__ = ["CASES", "GROUPS", "Case"]
