"""Start values that FMUs give themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.cosim.errors import ParameterError
from stickslip.fmi.messages import shown

if TYPE_CHECKING:
    from stickslip.cosim.system.system import System


def check_starts(system: System) -> None:
    """Check that what can be set starts within its range.

    Raises
    ------
    ParameterError
        Where an FMU contradicts itself and the system does not say better: the value is one that
        nobody else could give it.
    """
    for component, fmu in system.components.items():
        for variable in fmu.description.outside:
            name = f"{component}.{variable.name}"
            set_ = (n == name or n.startswith(f"{name}[") for n in system.parameters)
            if variable.is_settable and not any(set_):
                unit = f" {variable.unit}" if variable.unit else ""
                low, high = variable.minimum, variable.maximum
                wrong = f"outside its range {low} .. {high}{unit}"
                if low is None is high:
                    wrong = "no finite number"
                raise ParameterError(
                    f"{fmu.path}: {shown(name)} starts at {shown(str(variable.start))}{unit},"
                    f" {wrong}; give it another start value"
                )
