"""System structure packages, SSP 1.0 and 2.0: what the tool runs, other tools can open."""

from stickslip.cosim.ssp.read import read_ssp
from stickslip.cosim.ssp.structure import variants
from stickslip.cosim.ssp.write import write_ssp

__all__ = ["read_ssp", "variants", "write_ssp"]
