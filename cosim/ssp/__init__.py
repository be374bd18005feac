"""System structure packages, SSP 1.0 and 2.0: what the tool runs, other tools can open."""

from cosim.ssp.package import variants
from cosim.ssp.read import read_ssp
from cosim.ssp.write import write_ssp

__all__ = ["read_ssp", "variants", "write_ssp"]
