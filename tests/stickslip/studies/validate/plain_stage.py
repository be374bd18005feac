"""A stage with LuGre friction in a PI velocity loop, in plain Python; no stickslip in it."""

import math
from collections.abc import Callable
from pathlib import Path

M, B, F_S, F_C, V_S, SIGMA_0, SIGMA_1 = 5.5, 7.0, 9.0, 6.0, 5e-4, 4e5, 4.5e3
K_P, K_I, T_S, ENCODER = 1681.0, 137167.0, 5e-4, 1e-7
SUBSTEPS = 5


class Bristle:
    """LuGre friction along a velocity that is held from step to step."""

    def __init__(self) -> None:
        self.z = 0.0

    def force(self, v: float, h: float) -> float:
        """Return the mean friction over a step [N]."""
        rate = SIGMA_0 * abs(v) / (F_C + (F_S - F_C) * math.exp(-abs(v) / V_S))
        dz = (v / rate - self.z) * -math.expm1(-rate * h) if rate else 0.0
        self.z += dz
        return SIGMA_0 * self.z + SIGMA_1 * dz / h


def write_log(path: Path, command: Callable[[float], float], duration: float, share: float) -> None:
    """Write a log of the stage, compensated by a share of its friction at the command."""
    own, model, h = Bristle(), Bristle(), T_S / SUBSTEPS
    x = v = integral = last = 0.0
    with path.open("w", encoding="utf-8") as file:
        file.write("t [s],v_cmd [m/s],x_enc [m],F_motor [N]\n")
        for step in range(round(duration / T_S) + 1):
            wanted = command(step * T_S)
            shown = round(x / ENCODER) * ENCODER
            late = wanted - (shown - last) / T_S
            last = shown
            integral += K_I * T_S * late
            force = K_P * late + integral + share * model.force(wanted, T_S)
            file.write(f"{step * T_S:.4f},{wanted:.9g},{shown:.9g},{force:.9g}\n")
            for _ in range(SUBSTEPS):
                v += h / M * (force - own.force(v, h) - B * v)
                x += h * v
