"""Defects seeded into a sound FMU, one at a time, to see who finds them.

``python -m campaigns.defects`` asks `fmucheck`, FMPy and fmu-manipulation-toolbox and prints the
tables of ``docs/check-defects.md``; ``tests/fmucheck`` asks `fmucheck` alone.
"""
