"""Defects seeded into a sound FMU, one at a time; ``tests/fmucheck`` asks `fmucheck` for each."""
