"""Defects seeded into a sound FMU, one at a time, to see who finds them.

``python -m tests.corpus.defects`` asks `fmucheck`, FMPy and fmu-manipulation-toolbox and prints the
table of ``docs/check.md``; ``tests/fmucheck`` asks `fmucheck` alone.
"""
