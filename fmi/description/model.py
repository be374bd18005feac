"""What is read of a description."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stickslip.fmi.description.clocks import Clock
from stickslip.fmi.description.learned import LearnedVariables
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable


@dataclass(frozen=True)
class DefaultExperiment:
    """What an FMU or an SSP proposes. All times in s; None where it proposes nothing.

    ``tolerance`` is the relative one of solvers.
    """

    start: float | None = None
    stop: float | None = None
    step: float | None = None
    tolerance: float | None = None


@dataclass(frozen=True)
class Unknown:
    """An entry of ModelStructure.

    Attributes
    ----------
    dependencies : names of the variables it depends on; None where the FMU does not say
    """

    name: str
    dependencies: tuple[str, ...] | None


@dataclass(frozen=True)
class Description:
    """A description.

    Attributes
    ----------
    standard : 1, 2 or 3; what is FMI 1.0 is given in the form of FMI 2.0
    token : the GUID of FMI 2.0, the instantiation token of FMI 3.0
    licence : what the FMU says of it
    interfaces : ``CoSimulation``, ``ModelExchange`` or ``ScheduledExecution`` -> its attributes
    variables : by name, in the order of the file
    aliases : other name -> name, in FMI 3.0
    derivatives : of continuous states: name -> name of the state, None where it is not said
    derivative_of : name -> name of what it is the derivative of, whether a state is or not
    n_states, n_indicators : numbers of continuous states and of event indicators
    clocks : the input clocks
    learned : what it learns in a run
    remarks : what is wrong in it and no run needs, in lines
    """

    standard: int
    name: str
    token: str
    licence: str
    interfaces: Mapping[str, Mapping[str, str]]
    experiment: DefaultExperiment
    units: Mapping[str, Unit]
    variables: Mapping[str, Variable]
    aliases: Mapping[str, str]
    outputs: tuple[Unknown, ...]
    derivatives: Mapping[str, str | None]
    derivative_of: Mapping[str, str]
    n_states: int
    n_indicators: int
    clocks: tuple[Clock, ...]
    learned: LearnedVariables
    remarks: tuple[str, ...]
