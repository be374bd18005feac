"""Errors of the control room; the tree is drawn in ``cosim/control/__init__.py``."""

from stickslip.cosim.errors import CosimError


class LinearisationError(CosimError, ValueError):
    """An FMU or system has no states, or not those that are asked for."""
