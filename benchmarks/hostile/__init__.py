"""Hostile inputs of every kind, what we make of them and what FMPy does."""

from benchmarks.hostile import binaries, statuses
from benchmarks.hostile.case import GROUPS, Case

CASES: list[Case] = [
    *binaries.CASES,
    *statuses.CASES,
]
"""All of them, group by group."""

__all__ = ["CASES", "GROUPS", "Case"]
