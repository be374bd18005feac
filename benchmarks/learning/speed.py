"""A candidate of 10 s at 2 kHz: against the same physics as plain C, and FMPy's simulate_fmu."""

import ctypes
import time
from pathlib import Path

import fmpy
import numpy as np

from benchmarks.learning.problem import cost, problem
from stickslip import cosim, ga, models
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.fmi import toolchain
from stickslip.models.export.sources import COMPILER_OPTIONS, shared_files, variables_header

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


DURATION = 10.0


def measure(folder: Path, evaluations: int = 100) -> dict[str, float]:
    """Return ratios; learning and C take turns, and count the processor's seconds."""
    with cost(folder, duration=DURATION) as evaluate:
        specification, command = evaluate.specification, evaluate.inputs["v_cmd"]
        fused = FusedLoop(specification.system, specification.step, command)
        _check(evaluate, fused, command)
        rounds = max(1, evaluations // 100)
        ratios, ours, kernels = [], [], []
        for seed in range(rounds):
            limits = ga.Limits(evaluations=102)
            optimiser = ga.optimiser("default", problem(seed), limits, seed)
            seconds, _ = _timed(lambda o=optimiser: ga.learn(o, evaluate))
            tried = optimiser.history[list(LUGRE)].to_numpy()
            plain, _ = _timed(lambda t=tried: _run_all(fused, t))
            kernel, _ = _timed(lambda t=tried: [_simulate(evaluate, row) for row in t])
            ratios.append(seconds / plain)
            kernels.append(kernel / plain)
            ours.append(seconds / len(tried))
        sealed = cosim.write_fmu(specification.system, folder / "loop.fmu", step=specification.step)
        theirs = _fmpy(sealed, command, specification.step)
    return {
        "ms per evaluation, learning": 1e3 * float(np.median(ours)),
        "learning / fused C loop of the same candidates": float(np.median(ratios)),
        "runs of FMUs alone / fused C loop": float(np.median(kernels)),
        "FMPy's simulate_fmu of the loop in one FMU / learning": theirs / float(np.median(ours)),
    }


def _check(evaluate: ga.SimulatedCost, fused: FusedLoop, command: np.ndarray) -> None:
    values = {f"compensator.{name}": PAPER[name] for name in LUGRE}
    with evaluate.specification.prepare() as simulation:
        result = simulation.run(values, {"v_cmd": command})
    fused.set(values)
    fused.run()
    if not np.array_equal(result["drive.x_enc"], fused.x_enc):
        raise RuntimeError("the fused loop is not the loop of FMUs")


def _run_all(fused: FusedLoop, candidates: np.ndarray) -> None:
    for values in candidates:
        fused.set({f"compensator.{n}": v for n, v in zip(LUGRE, values, strict=True)})
        fused.run()


def _simulate(evaluate: ga.SimulatedCost, values: np.ndarray) -> None:
    parameters = dict(zip(evaluate.names, values.tolist(), strict=True))
    evaluate._simulation().run(parameters, evaluate.inputs)  # noqa: SLF001 - as `evaluate` does


def _fmpy(path: Path, command: np.ndarray, step: float) -> float:
    """Return the seconds of one run of the system in one FMU, read and unpacked before."""
    description = fmpy.read_model_description(path)
    folder = fmpy.extract(path)
    time_points = np.arange(len(command)) * step
    kinds = [("time", float), ("v_cmd", float)]
    table = np.array(list(zip(time_points, command, strict=True)), dtype=kinds)

    def simulate() -> object:
        times = {"stop_time": time_points[-1], "step_size": step, "output_interval": step}
        signals = {"input": table, "output": ["drive.x_enc", "nominal.v_r"]}
        return fmpy.simulate_fmu(folder, model_description=description, **times, **signals)

    simulate()
    return min(_timed(simulate)[0] for _ in range(3))


def _timed(run) -> tuple[float, object]:
    begin = time.process_time()
    result = run()
    return time.process_time() - begin, result
