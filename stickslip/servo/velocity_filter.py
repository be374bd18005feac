"""A stationary Kalman filter of an axis, from its encoder and its motor force.

    x' = v,   m v' = F - F_known - b v + d,   d' = white noise
    x_enc = x + error of the encoder's step

Of order 2, d is constant between samples and changes by T_s d_1 at each, and d_1' = white noise.

Between samples the force F moves as a current loop with the lag tau_i lets it, so it is known
throughout from its values at the samples. Then the prediction is exact, and without disturbance
and quantisation the estimate is the velocity itself.
"""

from dataclasses import dataclass

import control
import numpy as np
from scipy.linalg import block_diag

from stickslip.servo.axis import Axis, check


@dataclass(frozen=True)
class FilterSpecification:
    """Noise and disturbance that the filter assumes; raises ControlError out of their range."""

    encoder_step: float  # resolution of the encoder [m]
    force_noise: float  # standard deviation of the force from sample to sample [N]
    # standard deviation of the change of the unknown force in a second, which grows with the square
    # root of the time [N/s^0.5]; of its rate if the order is 2 [N/s^1.5]
    disturbance_rate: float
    order: int = 1  # of the random walk of the unknown force, 1 or 2

    def __post_init__(self) -> None:
        check("encoder_step", self.encoder_step, "m", self.encoder_step > 0.0, expected="above 0")
        check("force_noise", self.force_noise, "N", self.force_noise >= 0.0, expected="0 or above")
        rate = self.disturbance_rate
        check("disturbance_rate", rate, "N/s^0.5", rate > 0.0, expected="above 0")
        check("order", self.order, "1", self.order in (1, 2), expected="1 or 2")


@dataclass(frozen=True)
class VelocityFilter:
    """A designed filter."""

    axis: Axis  # what it was designed for
    T_s: float  # sample period [s]
    # gains from the innovation of the position [m] to position [1], velocity [1/s] and disturbing
    # force [N/m]
    L_x: float
    L_v: float
    L_d: float
    L_1: float = 0.0  # gain to the rate of the disturbing force [N/(m s)]; 0 if the order is 1

    def parameters(self) -> dict[str, float]:
        """Return the parameters of the velocity-filter FMU."""
        axis = {"m": self.axis.m, "b": self.axis.b, "tau_i": self.axis.tau_i}
        return {"T_s": self.T_s, **axis, "L_x": self.L_x, "L_v": self.L_v, "L_d": self.L_d}

    def system(self) -> control.StateSpace:
        """Return the filter from displacement per sample [m] and net force [N] to velocity [m/s].

        Its states are the innovation left after the last sample [m], v [m/s], d [N] and the
        net force at the last sample [N], and the rate of d [N/s] if the order is 2; all
        differences, so that none drifts.
        """
        return self._system(1, "v_est")

    def disturbance(self) -> control.StateSpace:
        """Return the filter from displacement and net force, as in ``system``, to d [N]."""
        return self._system(2, "d_hat")

    def _system(self, state: int, output: str) -> control.StateSpace:
        A, by_last, by_now = self.axis.period(self.T_s)
        unexpected = np.concatenate([[1.0], -A[0, 1:], [-by_last[0]], [1.0, -by_now[0]]])
        gain = np.array([self.L_x, self.L_v, self.L_d])
        row = np.zeros((4, 6))  # states and inputs: (rest, v, d, N_last, way, N)
        row[0] = (1.0 - self.L_x) * unexpected
        row[1, 1:3], row[1, 3], row[1, 5] = A[1, 1:], by_last[1], by_now[1]
        row[2, 2] = 1.0
        row[1:3] += np.outer(gain[1:], unexpected)
        row[3, 5] = 1.0
        A_f, B_f = row[:, :4], row[:, 4:]
        if self.L_1:  # d_1 += L_1 r, d += T_s d_1
            by_rate = np.array([[0.0], [0.0], [self.T_s], [0.0], [1.0]])
            A_f = np.hstack([np.vstack([A_f, np.zeros(4)]), by_rate])
            B_f = np.vstack([B_f, np.zeros(2)])
            A_f[:, :4] += self.L_1 * by_rate * unexpected[:4]
            B_f += self.L_1 * by_rate * unexpected[4:]
        row = np.hstack([A_f, B_f])[[state]]
        names = {"name": "estimator", "inputs": ["d", "N"], "outputs": output}
        return control.ss(A_f, B_f, row[:, :-2], row[:, -2:], self.T_s, **names)


@dataclass(frozen=True)
class Observer:
    """A disturbance observer whose estimate is compensated: the parameters of the dob FMU."""

    filter: VelocityFilter  # estimates the disturbing force
    share: float = 1.0  # of the estimate that is compensated

    def parameters(self) -> dict[str, float]:
        """Return the parameters of the FMU."""
        order = {"L_1": self.filter.L_1} if self.filter.L_1 else {}
        return {**self.filter.parameters(), **order, "share": self.share}


def design_velocity_filter(
    axis: Axis, T_s: float, specification: FilterSpecification
) -> VelocityFilter:
    """Return the stationary Kalman filter, by python-control's Riccati equation.

    The encoder's error counts as white with the variance step^2 / 12.

    Raises
    ------
    ControlError
        When T_s is not positive.
    numpy.linalg.LinAlgError
        When no gains follow from the weights.
    """
    s = specification
    check("T_s", T_s, "s", T_s > 0.0, expected="above 0")
    A, _, _ = axis.period(T_s)
    # In steps of the encoder, a period each: x / q, v T_s / q, d T_s^2 / (m q)
    unit = s.encoder_step / np.array([1.0, T_s, T_s**2 / axis.m])
    # A force that is held for a period, and the effect of a random walk of d within it
    held = np.append(A[:2, 2], 0.0)
    walk = np.array([[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1.0]])
    reach = np.array([T_s**2 / axis.m, T_s / axis.m, 1.0])
    Q = s.disturbance_rate**2 * T_s * walk * np.outer(reach, reach)
    if s.order == 2:
        ramp = np.eye(4)
        ramp[2, 3] = T_s  # changes d at the sample, before the period
        A, held = block_diag(A, np.eye(1)) @ ramp, np.append(held, 0.0)
        unit = np.append(unit, unit[2] / T_s)
        Q = np.diag([0.0, 0.0, 0.0, s.disturbance_rate**2 * T_s])
    Q += s.force_noise**2 * np.outer(held, held)
    n = len(unit)
    C, R = np.eye(1, n), np.array([[1 / 12]])
    _, P, _ = control.dlqe(A / unit[:, None] * unit, np.eye(n), C, Q / np.outer(unit, unit), R)
    gain = unit / unit[0] * P[:, 0] / (P[0, 0] + R[0, 0])
    return VelocityFilter(axis, T_s, *(float(value) for value in gain))
