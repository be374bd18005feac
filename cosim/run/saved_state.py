"""The state of a simulation that was halted: taken for a checkpoint, and put back."""

from __future__ import annotations

import os

import numpy as np

from stickslip.cosim.assembly.disturbances import held_values, hold_values
from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.errors import SimulationError
from stickslip.cosim.run.checkpoint import Checkpoint
from stickslip.cosim.run.stepping import Stepper, last_outputs


def taken(stepper: Stepper) -> Checkpoint:
    """Return the state of a run that was halted.

    Raises
    ------
    SimulationError
        When an FMU cannot give its state away.
    """
    plan, fmus = stepper.plan, stepper.fmus
    components = plan.spec.system.components
    if mute := [name for name, fmu in components.items() if not fmu.serializes]:
        raise SimulationError(
            f"the state cannot be saved: {', '.join(mute)} cannot serialise it"
            " (canSerializeFMUstate)"
        )
    row, done = fmus.memory.state(), fmus.run.done
    memory = {f"/{name}": values for name, values in fmus.coupled.memory().items()}
    memory["/held"] = held_values(fmus.slots, row[: fmus.run.width], done)
    for owner, general in fmus.general.items():
        memory |= {f"{owner}/{name}": values for name, values in general.memory().items()}
    for name, slot in fmus.slots.items():
        memory[f"{name}/outputs"] = last_outputs(slot)
    states = {name: fmus.state_of(name).save() for name in plan.order}
    starts = {n: float(v) for n, v in stepper.starts.items() if isinstance(v, int | float)}
    return Checkpoint(identity(plan), done, row, states, starts, memory)


def put_back(stepper: Stepper, checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Initialise the FMUs of a run that has begun, and bring them into a state read from a file.

    Raises
    ------
    SimulationError
        When the state is damaged, or an FMU does not take it.
    """
    fmus = stepper.fmus
    stepper.advance(0)  # initialised, the FMUs are in a mode that takes a state
    try:
        for name in stepper.plan.order:
            fmus.state_of(name).restore(checkpoint.states[name])
            general, memory = fmus.general.get(name), checkpoint.memory_of(name)
            if general and "times" in memory and general.recall(memory) not in {0, 1}:
                call = (general.c.called or b"").decode()
                raise SimulationError(f"{name}: {call} failed on resuming")
        fmus.coupled.recall(checkpoint.memory_of(""))
        fmus.memory.go_on(checkpoint.step, checkpoint.row)
        hold_values(fmus.slots, checkpoint.memory["/held"])
    except (KeyError, ValueError, IndexError, TypeError, OverflowError) as fault:
        raise SimulationError(f"{path}: the saved state is damaged: {fault!r}") from fault
    for name, slot in fmus.slots.items():  # the outputs are those that they were
        now = last_outputs(slot)
        then = checkpoint.memory_of(name).get("outputs", now)
        wrong = ~np.isclose(now, then, rtol=1e-6, atol=1e-9, equal_nan=True)
        if wrong.any():
            place = int(np.argmax(wrong))
            fmus.ready = False
            raise SimulationError(
                f"{stepper.plan.layout.outputs[name][place]}: is {now[place]:.9g} after its FMU"
                f" took the state from {path}, but was {then[place]:.9g} when that was saved: the"
                " FMU does not bring back its state, though it declares that it can"
            )


def identity(plan: Plan) -> dict[str, str]:
    """Return what must be the same for a saved state to be a simulation's, by what it is."""
    spec, system = plan.spec, plan.spec.system
    how = {
        "step": float(spec.step),
        "start": float(spec.start),
        "coupling": plan.coupling,
        "constant_step": spec.constant_step,
        "tolerance": spec.tolerance,
        "order of the components": ", ".join(plan.order),
        "signals": ", ".join(plan.layout.columns),
        "sums of squares": plan.layout.summed,
    }
    fmus = {f"component {name}": fmu.identity for name, fmu in system.components.items()}
    wiring = {
        f"input {target}": f"{source}, {system.scaling(source, target)}"
        for target, source in system.sources().items()
    }
    starts = {f"start value of {name}": value for name, value in system.parameters.items()}
    return {what: str(value) for what, value in {**fmus, **wiring, **starts, **how}.items()}
