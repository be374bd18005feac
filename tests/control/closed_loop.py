"""The velocity loop written out again, without python-control, and as a system of FMUs."""

import math
from pathlib import Path

import numpy as np
from scipy.linalg import expm

from stickslip import cosim
from stickslip.servo.axis import Axis
from stickslip.servo.systems import servo_loop
from stickslip.servo.velocity_loop import VelocityLoop

NO_FRICTION = {"F_s": 1e-9, "F_c": 1e-9, "sigma_0": 1e-3, "sigma_1": 0.0}


def sampled_axis(axis: Axis, T_s: float) -> np.ndarray:
    """Return what one period does to (x, v, motor force F, command u): the matrix exponential."""
    rates = np.zeros((4, 4))
    rates[0, 1] = 1.0
    rates[1, 1], rates[1, 2] = -axis.b / axis.m, 1.0 / axis.m
    if axis.tau_i > 0.0:
        rates[2, 2], rates[2, 3] = -1.0 / axis.tau_i, 1.0 / axis.tau_i
    return expm(rates * T_s)


def follow(loop: VelocityLoop, v_cmd: np.ndarray, F_ff: np.ndarray) -> np.ndarray:
    """Return the velocity (n,) [m/s] at the samples: controller and axis step by step."""
    move = sampled_axis(loop.axis, loop.T_s)
    weight = 1.0 - math.exp(-loop.T_s / loop.tau_f) if loop.tau_f > 0.0 else 1.0
    state = np.zeros(4)
    x_last = v_est = integral = 0.0
    velocity = []
    for command, feedforward in zip(v_cmd, F_ff, strict=True):
        x, v = state[:2]
        velocity.append(v)
        v_est += weight * ((x - x_last) / loop.T_s - v_est)
        x_last = x
        error = command - v_est
        integral += loop.T_s * loop.K_i * error
        state[3] = loop.K_p * error + integral + feedforward
        if loop.axis.tau_i == 0.0:
            state[2] = state[3]
        state = move @ state
    return np.array(velocity)


def ideal_servo(fmus: Path, loop: VelocityLoop) -> cosim.System:
    """Return controller and drive in a loop: no friction to speak of, nothing quantised."""
    system = servo_loop(fmus, loop)
    axis = {"m": loop.axis.m, "b": loop.axis.b, "current_loop": loop.axis.tau_i > 0.0}
    if loop.axis.tau_i > 0.0:
        axis["tau_i"] = loop.axis.tau_i
    ideal = {**axis, **NO_FRICTION, "encoder": False, "dac": False}
    system.parameters |= {f"drive.{name}": value for name, value in ideal.items()}
    return system
