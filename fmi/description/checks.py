"""What variables must not be, alone or together, so that a run means something."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault
from stickslip.fmi.description.variables import Variable
from stickslip.fmi.messages import shown


def check_distinct(
    variables: Sequence[Variable], elements: Sequence[Any], aliases: Mapping[str, str]
) -> None:
    """Check that names, and in FMI 3.0 value references, occur once."""
    names: set[str] = set(aliases)
    references: dict[int, str] = {}
    for variable, element in zip(variables, elements, strict=True):
        if variable.name in names:
            raise DescriptionFault(element, f"a second variable {shown(variable.name)}; rename it")
        names.add(variable.name)
        if element.tag == "ScalarVariable":  # FMI 2.0: those that share one are one quantity
            continue
        other = references.setdefault(variable.reference, variable.name)
        if other is not variable.name:
            raise DescriptionFault(
                element,
                f"valueReference {variable.reference} of {shown(variable.name)} is that of"
                f" {shown(other)} already; in FMI 3.0 each variable has its own",
            )


def check_numbers(variable: Variable, element: Any) -> None:
    """Check that a range holds a value and that a nominal value is one."""
    low, high, nominal = variable.minimum, variable.maximum, variable.nominal
    for what, number in (("min", low), ("max", high)):
        if number is not None and number != number:
            raise DescriptionFault(
                element, f"{what} of {shown(variable.name)} is nan, expected a number"
            )
    if low is not None and high is not None and low > high:
        raise DescriptionFault(
            element,
            f"min of {shown(variable.name)} is {low}, above its max {high}, so that no value is"
            " left; export it again",
        )
    if nominal is not None and not 0 < nominal < float("inf"):
        raise DescriptionFault(
            element, f"nominal of {shown(variable.name)} is {nominal}, expected a positive number"
        )


def starts_outside(variable: Variable) -> bool:
    """Tell whether a start value that the FMU itself gives is not in the variable's range."""
    start = variable.start
    if start is None or isinstance(start, (str, bytes, bool)):
        return False
    low = float("-inf") if variable.minimum is None else variable.minimum
    high = float("inf") if variable.maximum is None else variable.maximum
    values = start if isinstance(start, tuple) else (start,)
    return not all(low <= value <= high for value in values if not isinstance(value, (str, bytes)))
