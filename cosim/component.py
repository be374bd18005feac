"""The contract of what the master can step: an FMU, or a Python function; and names in a system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from stickslip.cosim.fmu.values import resized
from stickslip.fmi.description.learned import LearnedVariables
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable, parse_element

if TYPE_CHECKING:
    from stickslip.cosim.fmu.library import Library


Interface = Literal["co_simulation", "model_exchange"]


class Component:
    """What a system connects and a simulation steps; a kind sets what differs from the defaults.

    Attributes
    ----------
    label : file or function, for messages
    identity : what must be the same for a saved state to fit
    binary : key of its code: components with the same code have the same one
    version : of FMI, whose functions the table has: 2 or 3
    interface : the one it is run by
    variables : name -> Variable, inputs and outputs among them
    aliases : other name -> name
    units : name -> Unit
    feedthrough : output -> the inputs it depends on without delay
    experiment : the times it proposes, s, and the tolerance
    structural : names of structural parameters
    learned : what it learns in a run
    event_mode, has_arrays, needs_tool, once_per_process : see Fmu
    serializes, restores_state, interpolates_inputs, varies_step : its abilities
    """

    label: str
    identity: str
    binary: Path
    token = ""
    version: int = 2
    interface: Interface = "co_simulation"
    variables: Mapping[str, Variable]
    aliases: Mapping[str, str] = {}
    units: Mapping[str, Unit] = {}
    feedthrough: Mapping[str, frozenset[str]]
    experiment = DefaultExperiment()
    structural: Sequence[str] = ()
    learned = LearnedVariables()
    event_mode = has_arrays = needs_tool = once_per_process = False
    serializes = restores_state = interpolates_inputs = varies_step = False

    def table(self) -> Library:
        """Return the functions by which the master steps it, under their names in FMI.

        They are called in this order: ``Instantiate``; in each run ``Reset`` (not in the first one
        of an instance), ``SetupExperiment``, setters of start values, ``EnterInitializationMode``,
        setters of inputs and getters of outputs as often as loops need them, and
        ``ExitInitializationMode``; in each step setters of inputs, ``DoStep``, getters of outputs;
        ``Terminate`` at the end of the run; ``FreeInstance`` once. Where it declares
        ``restores_state``, its state is saved and restored between steps.

        A status beyond a warning ends the run with a ``SimulationError`` that names the component
        and the call; the component is then instantiated again before the next run. After ``fatal``
        nothing more is called on any of its instances. A step that is discarded is tried in parts
        where it declares ``restores_state`` and ``varies_step``.
        """
        raise NotImplementedError

    def restore(self) -> None:
        """Bring changed files of the component back before it is prepared."""

    def find(self, name: str, lengths: Mapping[str, int] | None = None) -> Variable | None:
        """Return a variable by name or alias, or an element of an array: ``name[i,j]``.

        ``lengths`` are the structural parameters that differ from their start values.
        """
        variable = self.variables.get(name) or self.variables.get(self.aliases.get(name, ""))
        if variable is not None:
            variable = resized(variable, lengths) if lengths else variable
            return variable if variable.name == name else replace(variable, name=name)
        if element := parse_element(name):
            array = self.find(element[0], lengths)
            return array.at(element[1]) if array is not None else None
        return None

    def unit(self, variable: Variable) -> Unit | None:
        """Return the unit of one of its variables, None when it has none."""
        if variable.unit is None:
            return None
        unit = self.units.get(variable.unit, Unit(variable.unit))
        return replace(unit, relative=True) if variable.relative else unit


def component_of(name: str) -> str:
    """Return ``component`` of ``component.variable``."""
    return name.partition(".")[0]


def variable_of(name: str) -> str:
    """Return ``variable`` of ``component.variable``; it may hold dots itself."""
    return name.partition(".")[2]


def check_name(name: str) -> str | None:
    """Return why nothing can be called so, as names head columns of tables; None where it can."""
    if not name or "." in name:
        return "it is empty or has a dot"
    if not name.isprintable():
        return "it has control characters"
    if name[0] in "=+-@":
        return f"it begins with {name[0]!r}, which spreadsheets take for a formula"
    return None
