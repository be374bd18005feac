"""The sampled velocity loop of a servo axis: PI controller, encoder, motor.

    v_cmd -> (+) -> C(z) -> hold -> 1/(tau_i s + 1) -> 1/(m s + b) -> v -> 1/s -> x
              ^ -                                                                |
              +------------- filter <- difference over T_s <------- sampler -----+

A velocity filter can take the place of difference and filter. It sees the motor force too, and
subtracts the feedforward force.

Everything is discretised exactly for a held force, so the loop of FMUs without friction and
quantisation follows the same difference equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from inspect import signature
from typing import Any

import control
import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import toeplitz

from stickslip.servo import frequency
from stickslip.servo.axis import Array, Axis, ControlError, LoopSpecification, check
from stickslip.servo.velocity_filter import VelocityFilter


@dataclass(frozen=True)
class VelocityLoop:
    """A designed loop.

    Attributes
    ----------
    axis, T_s, tau_f : what it was designed for
    K_p : proportional gain [N s/m]
    K_i : integral gain [N/m]
    open_loop : from velocity error to velocity estimate, discrete
    nominal : from v_cmd [m/s] to the velocity v_r [m/s], discrete, minimal: Fig. 2b of the paper
    compliance : from a feedforward force [N] to the velocity it adds [m/s], discrete
    acceleration : from a_cmd [m/s2] to the velocity that m_ff a_cmd adds [m/s], with the states of
        ``nominal``
    m_ff : mass in the feedforward of inertia [kg], 0 for none
    velocity_filter : what estimates the velocity, None for the controller's own difference; with
        it ``nominal`` is not minimal, and tau_f is without effect
    K_x : gain from the position error to the velocity command [1/s]: the outer loop of a cascade,
        0 for none; ``nominal`` contains it
    velocity_feedforward : share of v_cmd that a cascade adds to the velocity that its position
        error commands; with less than 1 it lags by (1 - velocity_feedforward) v / K_x
    """

    axis: Axis
    T_s: float
    tau_f: float
    K_p: float
    K_i: float
    open_loop: control.StateSpace
    nominal: control.StateSpace
    compliance: control.StateSpace
    acceleration: control.StateSpace
    m_ff: float = 0.0
    velocity_filter: VelocityFilter | None = None
    K_x: float = 0.0
    velocity_feedforward: float = 1.0

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as what it is designed from, for python-control's systems do not."""
        return partial(close_velocity_loop, **self._given), ()

    @property
    def _given(self) -> dict[str, Any]:
        """Arguments of ``close_velocity_loop``."""
        return {name: getattr(self, name) for name in signature(close_velocity_loop).parameters}

    def commands(self, v_cmd: Array) -> dict[str, Array]:
        """Return the inputs of the loop for velocities (n,) [m/s], one a sample.

        With feedforward of inertia also ``a_cmd``, the acceleration to the next velocity; with an
        outer loop also ``x_cmd``, the position from the begin on [m].
        """
        found = {"v_cmd": v_cmd}
        if self.m_ff:
            found["a_cmd"] = np.diff(v_cmd, append=v_cmd[-1]) / self.T_s
        if self.K_x:
            found["x_cmd"] = self.T_s * np.concatenate([[0.0], np.cumsum(v_cmd[:-1])])
        return found

    def response(self, v_cmd: Array) -> tuple[Array, Array]:
        """Return velocity [m/s] and position [m] without friction for velocities (n,), (n,) both.

        The position is the integral of the velocity over straight lines between the samples.
        """
        commands = self.commands(v_cmd)
        v = outputs(self.nominal, v_cmd)
        if self.m_ff:
            v = v + outputs(self.acceleration, commands["a_cmd"])
        return v, np.asarray(cumulative_trapezoid(v, dx=self.T_s, initial=0))

    def changed(self, **changes: Any) -> VelocityLoop:
        """Return the loop with other arguments of ``close_velocity_loop``.

        Raises
        ------
        ControlError
            When it is unstable.
        """
        return close_velocity_loop(**{**self._given, **changes})

    def margins(self) -> dict[str, float]:
        """Return crossover and closed-loop bandwidth [Hz], phase [deg] and gain margin [dB]."""
        crossover, phase, gain = frequency.stability_margins(self.open_loop)
        return {
            "crossover_Hz": crossover,
            "phase_margin_deg": phase,
            "gain_margin_dB": gain,
            "bandwidth_Hz": frequency.bandwidth(self.nominal),
        }

    def step_response(self, duration: float) -> tuple[np.ndarray, np.ndarray]:
        """Return time [s] and velocity [m/s], both (n,), after a step of 1 m/s at t = 0."""
        t = np.arange(round(duration / self.T_s) + 1) * self.T_s
        response = control.step_response(self.nominal, t)
        return t, np.asarray(response.outputs)


def outputs(system: control.StateSpace, u: Array, length: int = 128) -> Array:
    """Return the outputs (n,) of a discrete system of one input and output from rest, inputs (n,).

    As ``control.forced_response``, by blocks of ``length`` samples instead of one at a time.
    """
    B, C = system.B[:, 0], system.C[0]
    powers = [np.eye(system.nstates)]
    for _ in range(length):
        powers.append(system.A @ powers[-1])
    seen, reached = C @ np.array(powers), np.array(powers) @ B  # (length + 1, states) both
    pulse = np.concatenate([system.D[0], reached[:-2] @ C])
    blocks = np.pad(u, (0, -len(u) % length)).reshape(-1, length)
    forced, driven = blocks @ toeplitz(pulse, 0.0 * pulse).T, blocks @ reached[-2::-1]
    state = np.zeros(system.nstates)
    for y, next_state in zip(forced, driven, strict=True):
        y += seen[:-1] @ state
        state = powers[-1] @ state + next_state
    return forced.ravel()[: len(u)]


def design_velocity_loop(
    axis: Axis, specification: LoopSpecification, *, velocity_filter: VelocityFilter | None = None
) -> VelocityLoop:
    """Find the PI gains with the crossover and phase margin of the specification.

    Both are met exactly: at the crossover C(z) must be the complex number that turns the rest of
    the open loop into e^(j (phase margin - 180 deg)), and K_p and K_i are two real unknowns.

    Raises
    ------
    ControlError
        When that needs a negative gain, or leaves the closed loop unstable.
    """
    s = specification
    z = np.exp(2j * np.pi * s.bandwidth * s.T_s)
    plant, estimator = plant_and_estimator(axis, s.T_s, s.tau_f, velocity_filter)
    rest = complex((estimator * plant[1:, 0])(z))
    wanted = -np.exp(1j * np.radians(s.phase_margin)) / rest
    integrator = s.T_s * z / (z - 1.0)
    K_i = wanted.imag / integrator.imag
    K_p = wanted.real - K_i * integrator.real
    if K_i < 0.0 or K_p < 0.0:
        most = np.degrees(np.angle(-rest))  # with P alone
        least = most + np.degrees(np.angle(integrator))  # with I alone
        change = "raise the bandwidth or the margin"
        if K_i < 0.0:
            change = "lower the bandwidth, T_s, tau_f or the margin"
        raise ControlError(
            f"phase margin {s.phase_margin:g} deg at {s.bandwidth:g} Hz is out of reach: a PI "
            f"controller leaves {least:.1f} to {most:.1f} deg there; {change}"
        )
    gains = {"K_p": float(K_p), "K_i": float(K_i)}
    return close_velocity_loop(axis, s.T_s, s.tau_f, **gains, velocity_filter=velocity_filter)


def close_velocity_loop(
    axis: Axis,
    T_s: float,
    tau_f: float,
    K_p: float,
    K_i: float,
    *,
    m_ff: float = 0.0,
    velocity_filter: VelocityFilter | None = None,
    K_x: float = 0.0,
    velocity_feedforward: float = 1.0,
) -> VelocityLoop:
    """Close the loop with given gains; units as in ``VelocityLoop``.

    Raises
    ------
    ControlError
        When a time is out of its range, the closed loop is unstable, or the filter has another
        sample period.
    """
    check("T_s", T_s, "s", T_s > 0.0, expected="above 0")
    check("tau_f", tau_f, "s", tau_f >= 0.0, expected="0 or above")
    check("K_p", K_p, axis.unit("N s/m"), True, expected="a number")
    check("K_i", K_i, axis.unit("N/m"), True, expected="a number")
    controller = pi_controller(K_p, K_i, T_s, name="controller", inputs="e", outputs="u_pi")
    error = control.summing_junction(["v_cmd", "-v_est"], "e", name="error")
    plant, estimator = plant_and_estimator(axis, T_s, tau_f, velocity_filter)
    known = [] if velocity_filter is None else known_force(velocity_filter)
    force = control.summing_junction(["u_pi", "F_ff"], "u", name="force")
    parts = [plant, estimator, controller, error, force]
    closed = control.interconnect(
        [*parts, *known[:1]], inputs=["v_cmd", "F_ff"], outputs=["v", "d"]
    )
    if K_x:
        closed = _with_position(closed, K_x, velocity_feedforward)
    nominal, pushed = (
        control.ss(closed.A, closed.B[:, [k]], closed.C[:1], closed.D[:1, [k]], T_s) for k in (0, 1)
    )
    compliance = pushed
    if known:
        compliance = control.interconnect(
            [*parts, *known[1:]], inputs=["v_cmd", "F_ff"], outputs=["v"]
        )[0, 1]
    fastest = max(abs(nominal.poles()))
    if not fastest < 1.0:
        raise ControlError(
            f"K_p = {K_p:g} {axis.unit('N s/m')} and K_i = {K_i:g} {axis.unit('N/m')} leave the "
            "velocity loop unstable"
            f"{f' with K_x = {K_x:g} 1/s around it' if K_x else ''}: "
            f"a pole is at |z| = {fastest:.4f}"
        )
    return VelocityLoop(
        axis,
        T_s,
        tau_f,
        K_p,
        K_i=K_i,
        open_loop=estimator * plant[1:, 0] * controller,
        nominal=nominal,
        compliance=compliance,
        acceleration=control.ss(pushed.A, m_ff * pushed.B, pushed.C, m_ff * pushed.D, T_s),
        m_ff=m_ff,
        velocity_filter=velocity_filter,
        K_x=K_x,
        velocity_feedforward=velocity_feedforward if K_x else 1.0,
    )


def pi_controller(K_p: float, K_i: float, T_s: float, **names: Any) -> control.StateSpace:
    """Return u = K_p e + I+ with I+ = I + T_s K_i e, from e to u."""
    if K_i == 0.0:  # no integrator, whose pole would stay at 1
        return control.ss([], [], [], K_p, T_s, **names)
    return control.ss(1.0, T_s * K_i, 1.0, K_p + T_s * K_i, T_s, **names)


POSITION_LOOP = 75.4 / 849.0  # gain of the position loop, over the velocity loop's crossover


def position_loop(loop: VelocityLoop) -> VelocityLoop:
    """Return the cascade of a velocity loop and a proportional position controller."""
    return loop.changed(K_x=POSITION_LOOP * loop.K_p / loop.axis.m)


def _with_position(closed: control.StateSpace, K_x: float, share: float) -> control.StateSpace:
    """Close an outer loop around one from (v_cmd, F_ff) to (v, d); d does not depend on v_cmd.

    The further state is the position error e at a sample. The velocity loop follows a share of
    v_cmd and K_x e, and e+ = e + T_s v_cmd - d+.
    """
    A, B, C = closed.A, closed.B, closed.C
    followed = np.diag([share, 1.0])
    outer = np.block([[A, K_x * B[:, :1]], [-C[1:] @ A, 1.0 - K_x * C[1:] @ B[:, :1]]])
    moved = np.array([[closed.dt, 0.0]]) - C[1:] @ B @ followed
    outputs = np.hstack([C, K_x * closed.D[:, :1]])
    inputs = np.vstack([B @ followed, moved])
    return control.ss(outer, inputs, outputs, closed.D @ followed, closed.dt)


def plant_and_estimator(
    axis: Axis, T_s: float, tau_f: float, velocity_filter: VelocityFilter | None
) -> tuple[control.StateSpace, control.StateSpace]:
    """Return the axis, whose first output is v, and what estimates v from the others."""
    if velocity_filter is None:
        return _plant(axis, T_s), _estimator(T_s, tau_f)
    same = velocity_filter.T_s == T_s
    check("T_s of the velocity filter", velocity_filter.T_s, "s", same, expected=f"{T_s:g}")
    L_1 = velocity_filter.L_1
    check(
        "L_1 of the velocity filter", L_1, "N/(m s)", L_1 == 0.0, expected="0: a filter of order 1"
    )
    return plant_with_force(axis, T_s), velocity_filter.system()


def known_force(velocity_filter: VelocityFilter) -> list[control.StateSpace]:
    """Return the parts from motor force F to net force N: all of F, or F without F_ff."""
    T_s = velocity_filter.T_s
    keep = float(velocity_filter.axis.sampled(T_s).A[0, 0])
    return [
        control.summing_junction(["F"], "N", name="net"),
        control.ss(keep, 1 - keep, 1, 0, T_s, name="known", inputs="F_ff", outputs="F_known"),
        control.summing_junction(["F", "-F_known"], "N", name="net"),
    ]


def plant_with_force(axis: Axis, T_s: float) -> control.StateSpace:
    """Return ``_plant`` with one output more: the motor force F [N], which is its first state."""
    sampled = axis.sampled(T_s)
    A = np.array(sampled.A)
    A[-1, -1] = 0.0  # the last state is reset at each sample: the displacement in one period
    C = np.eye(3)[[1, 2, 0]]
    return control.ss(A, sampled.B, C, 0, T_s, name="axis", inputs="u", outputs=["v", "d", "F"])


@lru_cache(maxsize=16)
def _plant(axis: Axis, T_s: float) -> control.StateSpace:
    """Return the axis from held force u [N] to velocity v [m/s] and displacement d per sample [m].

    With d instead of the position no state drifts, and the realisation stays minimal.
    """
    full = plant_with_force(axis, T_s)
    first = 0 if axis.tau_i > 0.0 else 1  # without a lag no state holds the force
    A, B, C = full.A[first:, first:], full.B[first:], full.C[:2, first:]
    return control.ss(A, B, C, 0, T_s, name="axis", inputs="u", outputs=["v", "d"])


def _estimator(T_s: float, tau_f: float) -> control.StateSpace:
    """Return the velocity estimate of the controller: d / T_s [m/s] through the low-pass."""
    names = {"name": "estimator", "inputs": "d", "outputs": "v_est"}
    if tau_f == 0.0:
        return control.ss([], [], [], 1 / T_s, T_s, **names)
    keep = np.exp(-T_s / tau_f)
    return control.ss(keep, (1 - keep) / T_s, keep, (1 - keep) / T_s, T_s, **names)
