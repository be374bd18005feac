"""The peak sensitivity of a loop with any chain of compensators, measured on their FMUs.

In motion at constant velocity a sampled compensator is a linear system. Its response to an impulse
at each of its inputs is the difference of two runs of its FMU, without knowledge of what it
computes, so this holds for a compensator of the user's as well.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np

from stickslip import cosim, models
from stickslip.errors import UsageError, number
from stickslip.servo.measurement import Array
from stickslip.servo.sensitivity import ComplexArray, OpenLoop, Response
from stickslip.servo.systems import Compensator, lone_chain
from stickslip.servo.velocity_loop import VelocityLoop

SAMPLES = 2048  # length of the impulse responses
LOWEST = 4  # lowest frequency, in oscillations over that length, at which they are evaluated
SETTLED = 400  # samples at the operating point before the impulse
SPEED = 0.01  # operating point by default [m/s]
CHANGES = {"x_enc": 1e-8, "F_motor": 1e-4, "v_est": 1e-9, "u": 1e-4}
"""Size of the impulse [m, N, m/s, N]: small against a Stribeck velocity and a presliding force.

An observer's force is rounded by some 1e-10 N, because its gain multiplies a position of some
centimetres; the response to the impulse must be large against it.
"""


@dataclass(frozen=True)
class Robustness:
    """What the linear loop tells; infinite if it is unstable.

    Attributes
    ----------
    peak : peak sensitivity Ms
    noise : RMS of the velocity by white noise of the encoder, relative to that of the noise [1/s]

    gain_margin : smallest change of the gain at the command that makes it unstable, as a factor
        above 1; infinite for none
    phase_margin : smallest lag there that does [rad]; infinite for none
    """

    peak: float
    noise: float
    gain_margin: float = 1.0
    phase_margin: float = 0.0

    @classmethod
    def worst(cls, every: Sequence[Self]) -> Self:
        """Return the worst of each over several loops."""
        return cls(
            max(one.peak for one in every),
            max(one.noise for one in every),
            min(one.gain_margin for one in every),
            min(one.phase_margin for one in every),
        )


def sliding(
    loop: VelocityLoop, friction: float, samples: int, speed: float = SPEED
) -> dict[str, Array]:
    """Return what compensators see (samples,) at constant speed against a friction [N], by role."""
    v, force = np.full(samples, speed), np.full(samples, friction + loop.axis.b * speed)
    x = np.asarray(speed * loop.T_s * np.arange(samples), dtype=float)
    return {"v_ref": v, "x_enc": x, "F_motor": force, "v_est": v, "u": force}


def frequencies(loop: VelocityLoop) -> Array:
    """Return those at which responses are measured (n,) [Hz]."""
    return np.arange(LOWEST, SAMPLES + 1) / (2 * SAMPLES * loop.T_s)


class ChainResponse(ExitStack):
    """Measures a chain of compensators again and again, with other parameters.

    They are in the order in which their forces are added. At the speed [m/s] they slide, so that
    friction adds next to nothing to the loop.
    """

    def __init__(
        self, fmus: Path, loop: VelocityLoop, chain: Sequence[Compensator], speed: float = SPEED
    ) -> None:
        super().__init__()
        roles = {role for one in chain for role in one.ports.inputs.values()}
        self._roles = [role for role in CHANGES if role in roles]
        self._speed = speed
        self._simulation: cosim.Simulation | None = None
        self._opened: tuple[VelocityLoop, OpenLoop] | None = None
        if self._roles:
            system, self._force = lone_chain(fmus, loop, chain)
            stop = (SETTLED + SAMPLES) * loop.T_s
            prepared = system.prepare(step=loop.T_s, stop=stop, record=(self._force,))
            self._simulation = self.enter_context(prepared)

    def of(
        self,
        loop: VelocityLoop,
        values: Mapping[str, float],  # parameters of the chain, ``component.variable``
        friction: float,  # force of sliding [N], by which the motor moves the axis
        m: float | None = None,  # true mass [kg], by default that of the loop's axis
    ) -> Robustness:
        """Return how robust a loop with the chain is."""
        known = self._opened  # the loop without the chain, of the last call
        if known is None or known[0] is not loop or known[1].m != (m or loop.axis.m):
            known = self._opened = loop, OpenLoop(loop, m, frequencies(loop))
        opened = known[1]
        found = self.responses([opened], values, friction)
        if not found:
            return Robustness(np.inf, np.inf)
        (closed,) = found
        density = 2.0 * loop.T_s * np.abs(closed.noisy) ** 2
        noise = float(np.sqrt(np.trapezoid(density, opened.f)))
        return Robustness(closed.peak, noise, *closed.margins())

    def responses(
        self, axes: Sequence[OpenLoop], values: Mapping[str, float], friction: float
    ) -> list[Response]:
        """Return how a loop with the chain responds opened on several axes; none if unstable."""
        measured = self._impulses(axes[0].loop, values, friction) if self._simulation else {}
        found = [opened.response_with(measured) for opened in axes]
        return [response for response, _ in found] if all(stable for _, stable in found) else []

    def _impulses(
        self, loop: VelocityLoop, values: Mapping[str, float], friction: float
    ) -> dict[str, ComplexArray]:
        """Return the response of the chain's force to each signal that it takes, (n,)."""
        still = sliding(loop, friction, SETTLED + SAMPLES + 1, self._speed)
        simulation = self._simulation
        assert simulation is not None  # noqa: S101 - a signal is measured
        still = {role: still[role] for role in simulation.spec.system.inputs}
        before = simulation.run(values, still)[self._force]
        found = {}
        for role in self._roles:
            moved = still[role].copy()
            moved[SETTLED] += CHANGES[role]
            after = simulation.run(values, {**still, role: moved})[self._force]
            impulse = (after - before) / CHANGES[role]
            # Row k + 1 shows the force from sample k on.
            found[role] = np.fft.rfft(impulse[SETTLED + 1 :], 2 * SAMPLES)[LOWEST:]
        return found


def robustness(
    loop: VelocityLoop,
    compensators: Sequence[Compensator],
    *,
    friction: float,
    folder: Path | str = "fmus",
    m: float | None = None,
) -> Robustness:
    """Return the peak sensitivity Ms of a loop with compensators, and how it passes noise on.

    The compensators are FMUs of which nothing is known: their response to an impulse at each input
    is measured in motion at constant velocity, and the loop is closed over it.

    Parameters
    ----------
    loop, compensators, folder : as of ``ss.closed_loop``
    friction : force of sliding [N]
    m : true mass [kg], by default that of the loop's axis

    Raises
    ------
    UnknownModel, UnknownLaw
        When there is no such compensator.
    UsageError
        When friction is below 0, or the mass not above.
    """
    friction = number("friction", friction)
    if not 0.0 <= friction < math.inf:
        raise UsageError(f"friction = {friction:g} N: expected 0 or more")
    m = loop.axis.m if m is None else number("m", m)
    if not 0.0 < m < math.inf:
        raise UsageError(f"m = {m:g} kg: expected more than 0")
    fmus = Path(folder) / "chain"
    chain = built(fmus, (), compensators)
    with ChainResponse(fmus, loop, chain) as response:
        return response.of(loop, {}, friction, m)


def built(
    fmus: Path, others: Sequence[str], compensators: Sequence[Compensator]
) -> list[Compensator]:
    """Build FMUs into a folder; return the compensators with their files."""
    for name in others:
        models.build_fmu(name, fmus)
    files = ["_".join(filter(None, [one.model, one.law])) for one in compensators]
    for one, file in zip(compensators, files, strict=True):
        models.build_fmu(one.model, fmus, law=one.law or None, called=file)
    return [replace(one, file=file) for one, file in zip(compensators, files, strict=True)]
