"""What an FMU learns in a run: an annotation of ours, which any tool may write.

    <VendorAnnotations><Tool name="stickslip">               in FMI 2.0
    <Annotations><Annotation type="stickslip">               in FMI 3.0
        <Learned model="lffc">
            <State parameter="w_0" variable="w"/>

``parameter`` takes over the value that ``variable`` has at the end of another run; of arrays, all
elements.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault
from stickslip.fmi.description.variables import Variable
from stickslip.fmi.messages import shown

ANNOTATION = "stickslip"
"""Name of the tool in FMI 2.0, type of the annotation in FMI 3.0."""
_PLACES = (
    f"VendorAnnotations/Tool[@name='{ANNOTATION}']/Learned/State",
    f"Annotations/Annotation[@type='{ANNOTATION}']/Learned/State",
)


@dataclass(frozen=True)
class LearnedVariables:
    """What an FMU learns.

    Attributes
    ----------
    model : that learns; empty where the FMU learns nothing
    variables : parameter -> variable, both scalars or elements of arrays
    """

    model: str = ""
    variables: Mapping[str, str] = field(default_factory=dict)


def read_learned(root: Any, variables: Mapping[str, Variable]) -> LearnedVariables:
    """Return what the annotation of a description says."""
    model, found = "", dict[str, str]()
    for element in (each for place in _PLACES for each in root.iterfind(place)):
        model = element.getparent().get("model", "")
        ends = [element.get(end, "") for end in ("parameter", "variable")]
        parameters, learned = (_elements(end, variables) for end in ends)
        if not parameters or len(parameters) != len(learned):
            what = " and ".join(map(shown, ends))
            raise DescriptionFault(element, f"{what} are not variables of the same size")
        found |= dict(zip(parameters, learned, strict=True))
    return LearnedVariables(model, found)


def _elements(name: str, variables: Mapping[str, Variable]) -> list[str]:
    """Return a scalar, or the elements of an array, which in FMI 2.0 are scalars."""
    if name in variables:
        return [each.name for each in variables[name].elements()]
    return [each for each in variables if each.partition("[")[0] == name]
