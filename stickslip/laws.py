"""A friction law by itself, under an imposed motion or force."""

import math
import tempfile
from collections.abc import Mapping

import numpy as np

from stickslip import cosim, models
from stickslip.cosim.signals.signals import Input, sampled
from stickslip.errors import UsageError, number
from stickslip.simulation import simulate

_MOST_STEPS = 1e8


def run_law(
    law: str,
    *,
    velocity: Input | None = None,
    position: Input | None = None,
    force: Input | None = None,
    stop: float,
    step: float = 1e-4,
    parameters: Mapping[str, float] | None = None,
) -> cosim.Result:
    """Run a friction law by itself: impose a motion and read the force, or the reverse.

    A motion is imposed on the law alone, in the FMU ``compensator``: the velocity is held over
    each step. A force pushes the FMU ``stage``, a mass with viscous friction on the contact.

    Parameters
    ----------
    law : name of a law, such as ``lugre``; ``ss.law_names()`` lists them
    velocity, position, force : one of them [m/s, m, N]: an array (n,), a signal, or a function of
        the times (n,) [s]
    stop, step : length of the run, rounded up to whole steps, and of the steps [s]
    parameters : of the law, and of the stage ``m`` and ``b``, in SI units; else start values of
        law.toml

    Returns
    -------
    Result
        with the law as the name of the component: ``F_f``, friction at the end of each step [N];
        with a motion also ``F_mean``, its mean over the step; with a force also ``x`` and ``v``

    Raises
    ------
    UsageError
        When not one of velocity, position and force is given, or the times make no run.
    UnknownLaw, StartValueError
        When there is no such law or parameter.
    """
    given = {"velocity": velocity, "position": position, "force": force}
    (name, signal), *more = [*(item for item in given.items() if item[1] is not None), ("", None)]
    if len(more) != 1 or signal is None:
        raise UsageError("expected one of velocity, position and force")
    stop, step = number("stop", stop), number("step", step)
    model, driven = ("stage", "u") if name == "force" else ("compensator", "v")
    if not (0.0 < step < math.inf and 0.0 < stop < math.inf and stop / step <= _MOST_STEPS):
        raise UsageError(
            f"stop = {stop} s and step = {step} s: expected positive numbers, at most"
            f" {_MOST_STEPS:g} steps"
        )
    steps = math.ceil(stop / step - 1e-6)
    if name == "position":
        time = np.arange(steps + 1, dtype=np.float64) * step
        way = np.diff(np.broadcast_to(sampled("position", signal, time), time.shape))
        signal = np.append(way, 0.0) / step
    with tempfile.TemporaryDirectory() as folder:
        fmu = models.build_fmu(model, folder, law=law, start=parameters, called=law)
        return simulate(fmu, stop=steps * step, step=step, inputs={driven: signal})
