"""The sensitivity of a velocity loop, with or without a disturbance observer.

    v_cmd -> C(z) -> (+) -> u -> axis -> displacement d per sample, motor force F
                      ^                       |
                      +---- -share d_hat <- observer

The observer sees the motor force, so the loop has two places where it can be opened to one input
and one output. At the command u the sensitivity is that to the lag of the current loop and to
delays; at the encoder it is that to the mass. Where the observer's axis is the true one, the first
does not depend on the observer, and the second is 1 - Q times it where d_hat = Q d.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import control
import numpy as np
from numpy.typing import NDArray

from stickslip.servo.axis import Array, Axis
from stickslip.servo.frequency import respond
from stickslip.servo.velocity_filter import Observer, VelocityFilter
from stickslip.servo.velocity_loop import (
    VelocityLoop,
    known_force,
    pi_controller,
    plant_and_estimator,
    plant_with_force,
)

ComplexArray = NDArray[np.complex128]
LOWEST = 1e-5  # lowest frequency that is evaluated, as a share of the sample rate
FREQUENCIES = 600  # frequencies that are evaluated, evenly spaced in the logarithm


@dataclass(frozen=True)
class Response:
    """How a loop with an observer responds at each frequency of its ``OpenLoop`` loop."""

    # (n,) sensitivity 1 / (1 + L) where the loop is opened there
    at_command: ComplexArray
    at_encoder: ComplexArray
    disturbed: ComplexArray  # (n,) from a force on the mass to the velocity [m/(N s)]
    noisy: ComplexArray  # (n,) from an error of the encoder to the velocity [1/s]
    driven: ComplexArray  # (n,) from an error of the measured motor force to the velocity [m/(N s)]

    @property
    def peak(self) -> float:
        """The peak sensitivity Ms: the largest at either place."""
        return float(max(np.abs(self.at_command).max(), np.abs(self.at_encoder).max()))

    def margins(self) -> tuple[float, float]:
        """Return gain margin, as a factor, and phase margin [rad] at the command.

        Linear between the frequencies. The gain margin is the nearest to 1 of all factors up and
        down, as one above 1; infinite where the phase, or the gain, crosses nowhere.
        """
        L = 1.0 / self.at_command - 1.0
        size, turned = np.log(np.abs(L)), np.angle(-L)
        k = np.flatnonzero(np.sign(size[1:]) != np.sign(size[:-1]))
        share = size[k] / (size[k] - size[k + 1])
        at_one = L[k] + share * (L[k + 1] - L[k])
        phases = np.abs(np.angle(-at_one))
        k = np.flatnonzero((np.sign(turned[1:]) != np.sign(turned[:-1])) & (L.real[1:] < 0.0))
        share = L.imag[k] / (L.imag[k] - L.imag[k + 1])
        gains = np.abs(np.log(np.abs(L.real[k] + share * (L.real[k + 1] - L.real[k]))))
        return float(np.exp(gains.min(initial=np.inf))), float(phases.min(initial=np.inf))


class OpenLoop:
    """A velocity loop on an axis, opened at the controller, for which observers are tried.

    The true mass m [kg] is by default that of the axis for which the loop was designed, the
    frequencies f (n,) [Hz] are ``FREQUENCIES`` up to half the sample rate.
    """

    def __init__(self, loop: VelocityLoop, m: float | None = None, f: Array | None = None) -> None:
        self.loop, self.T_s, self.m = loop, loop.T_s, m or loop.axis.m
        if f is None:
            f = np.geomspace(LOWEST / self.T_s, 0.5 / self.T_s, FREQUENCIES)
        self.f = f
        axis = replace(loop.axis, m=self.m)
        self.plant, self.z, *responses = _plant(axis, self.T_s, f.tobytes())
        self._moved, self._force, self._pushed = responses

    @cached_property
    def _controller(self) -> tuple[control.StateSpace, control.StateSpace]:
        """From (d, F) to the controller's force, and from the compensator's force to u."""
        loop = self.loop
        pi = pi_controller(loop.K_p, loop.K_i, loop.T_s)
        _, estimator = plant_and_estimator(loop.axis, loop.T_s, loop.tau_f, loop.velocity_filter)
        if loop.K_x:  # the position is the sum of the displacements
            ahead = np.array([[loop.K_x] + [0.0] * (estimator.ninputs - 1)])
            estimator = estimator + control.ss(1.0, ahead / loop.K_x, loop.K_x, ahead, loop.T_s)
        one = control.ss([], [], [], 1.0, loop.T_s)
        if loop.velocity_filter is None:
            return -pi * estimator * control.ss([], [], [], [[1.0, 0.0]], loop.T_s), one
        lag = known_force(loop.velocity_filter)[1]
        return -pi * estimator, one + pi * estimator[0, 1] * lag

    @cached_property
    def _controlled(self) -> tuple[ComplexArray, ComplexArray]:
        own, added = (respond(part, self.z) for part in self._controller)
        return own[:, 0], added[:, 0, 0]

    def response(self, observer: Observer | None = None) -> Response:
        """Return the response with an observer, or without."""
        if observer is None:
            return self._closed(0.0, 0.0)
        estimate = _estimate(observer.filter, self.z.tobytes())
        return self._closed(*(-observer.share * estimate.T))

    def response_with(self, compensator: Mapping[str, ComplexArray]) -> tuple[Response, bool]:
        """Return the response with a compensator, and whether the loop is stable.

        The compensator, stable by itself, is its response (n,) from a signal to its force at ``z``,
        by the role of the signal: ``x_enc``, ``F_motor``, ``u``, ``v_est``; the last two are those
        of the sample before.
        """
        late = 1.0 / self.z
        by = {role: compensator.get(role, 0.0) for role in ("x_enc", "F_motor", "u")}
        by_d = by["x_enc"] / (1.0 - late)
        if "v_est" in compensator:
            _, estimator = plant_and_estimator(self.loop.axis, self.T_s, self.loop.tau_f, None)
            by_d = by_d + compensator["v_est"] * late * respond(estimator, self.z)[:, 0, 0]
        response, plain = self._closed(by_d, by["F_motor"], by["u"] * late), self._closed(0.0, 0.0)
        # Nyquist: each unstable pole turns the ratio of the return differences by half a circle.
        turned = np.unwrap(np.angle(plain.at_command / response.at_command))
        return response, self._is_stable and bool(abs(turned[-1] - turned[0]) < 0.75 * np.pi)

    def _closed(
        self, to_d: ComplexArray | float, to_F: ComplexArray | float, to_u: ComplexArray | float = 0
    ) -> Response:
        """Return the response with a compensator's force from displacement, motor force and u."""
        own, added = self._controlled
        by_d, by_F, by_u = own[:, 0] + added * to_d, own[:, 1] + added * to_F, added * to_u
        at_command = 1.0 / (1.0 - by_d * self._moved - by_F * self._force - by_u)
        at_encoder = (1.0 - by_F * self._force - by_u) * at_command
        return Response(
            at_command,
            at_encoder,
            disturbed=at_encoder * self._pushed / self.T_s,
            noisy=(1.0 - 1.0 / self.z) * (at_encoder - 1.0) / self.T_s,
            driven=at_command * by_F * self._moved / self.T_s,
        )

    @cached_property
    def _is_stable(self) -> bool:
        return self.stable()

    def stable(self, observer: Observer | None = None) -> bool:
        """Return whether the closed loop is stable."""
        feedback, added = self._controller
        if observer is not None:
            feedback = feedback - observer.share * added * observer.filter.disturbance()
        closed = control.feedback(self.plant, feedback, sign=1)
        return bool(max(abs(closed.poles()), default=0.0) < 1.0)


def peak_sensitivity(
    loop: VelocityLoop, observer: Observer | None = None, m: float | None = None
) -> float:
    """Return the peak sensitivity Ms of a loop up to half the sample rate; infinite if unstable.

    The observer, if any, compensates beside the controller. The true mass m [kg] is by default that
    of the loop's axis.
    """
    opened = OpenLoop(loop, m)
    return opened.response(observer).peak if opened.stable(observer) else float("inf")


@lru_cache
def _plant(axis: Axis, T_s: float, f: bytes) -> tuple[Any, ...]:
    """Return the axis, the points z, and the responses to u and to a force at frequencies [Hz]."""
    plant = plant_with_force(axis, T_s)[1:, 0]
    z = np.exp(2j * np.pi * np.frombuffer(f) * T_s)
    moved, force = respond(plant, z)[:, :, 0].T
    unlagged = plant_with_force(Axis(axis.m, axis.b), T_s)[1, 0]
    return plant, z, moved, force, respond(unlagged, z)[:, 0, 0]


@lru_cache(maxsize=1)
def _estimate(estimator: VelocityFilter, z: bytes) -> ComplexArray:
    """Return the response (n, 2) of an estimated force, the same for a loop of any true mass."""
    return respond(estimator.disturbance(), np.frombuffer(z, dtype=complex))[:, 0]
