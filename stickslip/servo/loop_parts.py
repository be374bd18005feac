"""The parts that ``velocity_loop`` closes: axis, estimate of the velocity, known forces."""

from __future__ import annotations

import control
import numpy as np

from stickslip.servo.axis import Axis, check
from stickslip.servo.velocity_filter import VelocityFilter


def plant_and_estimator(
    axis: Axis, T_s: float, tau_f: float, velocity_filter: VelocityFilter | None
) -> tuple[control.StateSpace, control.StateSpace]:
    """Return the axis, whose first output is v, and what estimates v from the others.

    Raises
    ------
    ControlError
        When the filter has another sample period.
    """
    if velocity_filter is None:
        return _plant(axis, T_s), _estimator(T_s, tau_f)
    same = velocity_filter.T_s == T_s
    check("T_s of the velocity filter", velocity_filter.T_s, "s", same, f"{T_s:g}")
    return _plant_with_force(axis, T_s), velocity_filter.system()


def known_force(velocity_filter: VelocityFilter) -> list[control.StateSpace]:
    """Return what makes the net force N of the motor force F: all of it, or less F_ff."""
    T_s = velocity_filter.T_s
    keep = float(velocity_filter.axis.sampled(T_s).A[0, 0])
    return [
        control.summing_junction(["F"], "N", name="net"),
        control.ss(keep, 1 - keep, 1, 0, T_s, name="known", inputs="F_ff", outputs="F_known"),
        control.summing_junction(["F", "-F_known"], "N", name="net"),
    ]


def _plant_with_force(axis: Axis, T_s: float) -> control.StateSpace:
    """Return ``_plant`` with one output more: the motor force F [N], which is its first state."""
    sampled = axis.sampled(T_s)
    A = np.array(sampled.A)
    A[-1, -1] = 0.0  # the way in one period, as in _plant
    C = np.eye(3)[[1, 2, 0]]
    return control.ss(A, sampled.B, C, 0, T_s, name="axis", inputs="u", outputs=["v", "d", "F"])


def _plant(axis: Axis, T_s: float) -> control.StateSpace:
    """Return the axis from held force u [N] to velocity v [m/s] and way d per sample [m].

    With d instead of the position no state drifts, and the realisation stays minimal.
    """
    if axis.tau_i > 0.0:
        A = np.array([[-1 / axis.tau_i, 0, 0], [1 / axis.m, -axis.b / axis.m, 0], [0, 1, 0]])
        B = np.array([[1 / axis.tau_i], [0], [0]])
    else:
        A = np.array([[-axis.b / axis.m, 0], [1, 0]])
        B = np.array([[1 / axis.m], [0]])
    sampled = control.sample_system(control.ss(A, B, np.eye(len(A)), 0), T_s, method="zoh")
    A, B = np.array(sampled.A), np.array(sampled.B)
    A[-1, -1] = 0.0  # the last state is reset at each sample: the displacement in one period
    return control.ss(
        A, B, np.eye(len(A))[-2:], 0, T_s, name="axis", inputs="u", outputs=["v", "d"]
    )


def _estimator(T_s: float, tau_f: float) -> control.StateSpace:
    """Return the velocity estimate of the controller: d / T_s [m/s] through the low-pass."""
    names = {"name": "estimator", "inputs": "d", "outputs": "v_est"}
    if tau_f == 0.0:
        return control.ss([], [], [], 1 / T_s, T_s, **names)
    keep = np.exp(-T_s / tau_f)
    return control.ss(keep, (1 - keep) / T_s, keep, (1 - keep) / T_s, T_s, **names)
