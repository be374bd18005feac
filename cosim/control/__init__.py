"""python-control and FMUs: linear models of FMUs, and measured frequency responses.

LinearisationError(CosimError)   an FMU or system has not the states, inputs or outputs it needs
"""

from stickslip.cosim.control.linearise import linearise, nonlinear_system
from stickslip.cosim.control.sweep import MeasuredResponse, measure_response
from stickslip.cosim.errors import LinearisationError

__all__ = [
    "LinearisationError",
    "MeasuredResponse",
    "linearise",
    "measure_response",
    "nonlinear_system",
]
