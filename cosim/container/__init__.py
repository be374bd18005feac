"""Whole systems as FMUs for other tools."""

from stickslip.cosim.container.write import write_fmu

__all__ = ["write_fmu"]
