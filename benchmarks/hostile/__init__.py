"""Hostile inputs of every kind, what we make of them and what FMPy does."""

from benchmarks.hostile import statuses
from benchmarks.hostile.case import GROUPS, Case

CASES: list[Case] = [*statuses.CASES]
"""All of them, group by group."""

__all__ = ["CASES", "GROUPS", "Case"]
