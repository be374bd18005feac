"""The paper's loop as plain C without FMI, checked bit for bit against the FMUs."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from stickslip import cosim, models
from stickslip.fmi import toolchain
from stickslip.models.export.headers import variables_header
from stickslip.models.export.sources import COMPILER_OPTIONS, shared_files

MODELS = {
    "nominal": "nominal_loop",
    "compensator": "compensator",
    "controller": "velocity_controller",
    "drive": "drive",
}
ROOT = Path(models.__file__).parent


class FusedLoop:
    """Runs a system of `stickslip.servo.systems.paper_loop` for a command (n + 1,) [m/s]."""

    def __init__(self, system: cosim.System, step: float, command: np.ndarray) -> None:
        self._run = ctypes.CDLL(str(_library())).run
        self._step = step
        self._command = np.ascontiguousarray(command)
        self._places: dict[str, tuple[str, int]] = {}
        self._parameters: dict[str, np.ndarray] = {}
        for component, model in MODELS.items():
            fields = [v for v in models.load_model(model).variables if v.role == "parameter"]
            self._parameters[component] = np.array([float(v.start) for v in fields])
            self._places |= {f"{component}.{v.name}": (component, i) for i, v in enumerate(fields)}
        self.set(system.parameters)
        self.x_enc, self.v_r = np.empty_like(command), np.empty_like(command)

    def set(self, parameters) -> None:
        for name, value in parameters.items():
            component, place = self._places[name]
            self._parameters[component][place] = float(value)

    def run(self) -> None:
        arrays = (self._command, *self._parameters.values(), self.x_enc, self.v_r)
        pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in arrays]
        n = ctypes.c_size_t(len(self._command) - 1)
        if self._run(n, ctypes.c_double(self._step), *pointers):
            raise RuntimeError("the fused loop diverged")


def _library() -> Path:
    files = {"fused.c": Path(__file__).with_name("fused.c").read_text()}
    for path in shared_files(models.load_model("drive")):
        included = path.suffix == ".c"
        name = f"{path.relative_to(ROOT).as_posix()}{'.inc' if included else ''}"
        files[name] = path.read_text()
    files["model.h"] = (ROOT / "adapter" / "model.h").read_text()
    files["variables.h"] = "#include VARIABLES\n"
    for name in MODELS.values():
        model = models.load_model(name)
        files[f"{name}/model.c.inc"] = (model.folder / "model.c").read_text()
        files[f"{name}/variables.h"] = variables_header(model)
    files["fused.c"] = files["fused.c"].replace('.c"', '.c.inc"')
    flags = ["-Wno-unused-parameter", "-Wno-unused", *COMPILER_OPTIONS.split()]  # the FMUs' own
    return toolchain.shared_library("fused", files, flags=flags)
