"""Defects seeded into a sound FMU, one at a time, for ``tests/fmucheck``."""
