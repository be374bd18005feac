"""Single models, stepped by the kernel; and the C of models/ as functions on arrays."""

import ctypes
import functools
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.fmi import toolchain
from stickslip.models.export.sources import shared_files, variables_header
from tests.cosim.single import exposed
from tests.models.contacts import TABLE_2

MODELS = Path(models.__file__).parent


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build every model once; return the folder."""
    folder = tmp_path_factory.mktemp("fmus")
    for name in models.model_names():
        models.build_fmu(name, folder)
    return folder


@pytest.fixture
def observe(fmus: Path) -> Callable[..., cosim.Result]:
    """Run a model at 2 kHz as ``fmu``: ``observe("dob", {"x_enc": x}, share=0.5)``.

    A path may stand for the name; inputs without a signal keep their start values.
    """

    def observe(
        name: str | Path,
        signals: Mapping[str, np.ndarray],
        record: tuple[str, ...] | None = None,
        **parameters: float,
    ) -> cosim.Result:
        path = fmus / f"{name}.fmu" if isinstance(name, str) else name
        system = exposed(path, parameters, "fmu")
        stop = 5e-4 * (len(next(iter(signals.values()))) - 1)
        options = {"step": 5e-4, "stop": stop, "record": record}
        return system.prepare(constant_step=True, **options).run(inputs=signals)

    return observe


Prepare = Callable[..., cosim.Simulation]


@pytest.fixture
def alone(fmus: Path) -> Prepare:
    """Prepare one model, its inputs exposed: ``alone("stage", step=5e-4, stop=1.0)``."""

    def alone(name: str, record: tuple[str, ...] | None = None, **options: float) -> object:
        return exposed(fmus / f"{name}.fmu", name=name).prepare(record=record, **options)

    return alone


@pytest.fixture(scope="session")
def with_law(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """Build a model with a friction law once: ``with_law("stage", "gms")``."""
    folder = tmp_path_factory.mktemp("laws")

    @functools.cache
    def build(name: str, law: str) -> Path:
        return models.build_fmu(name, folder / law, law=law)

    return build


def _run(
    path: Path, h: float, values: np.ndarray, parameters: Mapping[str, float]
) -> dict[str, np.ndarray]:
    system = exposed(path, parameters, "fmu")
    [fed] = system.inputs
    values = np.append(values, values[-1])
    result = system.prepare(step=h, stop=h * (len(values) - 1)).run(inputs={fed: values})
    return {name[4:]: result[name].copy() for name in result.names if name.startswith("fmu.")}


@pytest.fixture
def follow(with_law: Callable[[str, str], Path]) -> Callable[..., dict[str, np.ndarray]]:
    """Drive a law at held velocities: ``follow("gms", h, v, F_c=5.0)``.

    ``F_mean`` (n,) are the mean forces over the n steps, ``F_f`` (n + 1,) the forces between them.
    """

    def follow(law: str, h: float, v: np.ndarray, **parameters: float) -> dict[str, np.ndarray]:
        found = _run(with_law("compensator", law), h, v, parameters)
        return {"F_mean": found["F_mean"][1:], "F_f": found["F_f"]}

    return follow


@pytest.fixture
def push(with_law: Callable[[str, str], Path]) -> Callable[..., dict[str, np.ndarray]]:
    """Push the stage with held forces: ``push("gms", h, u, F_c=5.0)`` returns (n + 1,) arrays."""

    def push(law: str, h: float, u: np.ndarray, **parameters: float) -> dict[str, np.ndarray]:
        return _run(with_law("stage", law), h, u, parameters)

    return push


@pytest.fixture(scope="session")
def library() -> ctypes.CDLL:
    """Compile the shared C of models/ with ``probe.c``, which exports it."""
    model = models.load_model("stage")
    files = {path.relative_to(MODELS).as_posix(): path.read_text() for path in shared_files(model)}
    files["variables.h"] = variables_header(model)
    # The probe takes the step apart, so it includes this file instead of linking it.
    files["laws/lugre/motion.inc"] = files.pop("laws/lugre/motion.c")
    files["probe.c"] = Path(__file__).with_name("probe.c").read_text()
    return ctypes.CDLL(str(toolchain.shared_library("probe", files, flags=["-lm"])))


@pytest.fixture(scope="session")
def c(library: ctypes.CDLL) -> Callable[..., np.ndarray]:
    """Call ``probe.c``: ``c("exp", x)`` maps an array."""

    def call(name: str, x: np.ndarray) -> np.ndarray:
        x = np.ascontiguousarray(x, dtype=float)
        y = np.empty_like(x)
        getattr(library, f"probe_{name}")(ctypes.c_size_t(x.size), _of(x), _of(y))
        return y

    return call


def _of(array: np.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def _contact(p: Mapping[str, float]) -> ctypes.Array[ctypes.c_double]:
    names = ("F_s", "F_c", "v_s", "sigma_0", "sigma_1", "delta")
    return (ctypes.c_double * 6)(*({"delta": 1.0, **p}[name] for name in names))


@pytest.fixture(scope="session")
def mass_run(library: ctypes.CDLL) -> Callable[..., np.ndarray]:
    """Move a mass on a contact under a held force.

    ``mass_run(method, h, u, pieces, m, b, contact, start)`` returns x, v, z after each hold of h
    seconds, (len(u), 3). Methods: ``adaptive``, the step of models/; ``rodas3``, the same with
    ``pieces`` equal sub-steps; ``rk4``, written for the tests alone, likewise.
    """

    def run(
        method: str,
        h: float,
        u: np.ndarray,
        pieces: int = 1,
        m: float = 5.557,
        b: float = 6.6135,
        contact: Mapping[str, float] = TABLE_2,
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> np.ndarray:
        u = np.ascontiguousarray(u, dtype=float)
        motion = np.empty((len(u), 3))
        library.probe_run(
            ["adaptive", "rodas3", "rk4"].index(method),
            pieces,
            ctypes.c_double(h),
            ctypes.c_size_t(len(u)),
            _of(u),
            (ctypes.c_double * 2)(m, b),
            _contact(contact),
            (ctypes.c_double * 3)(*start),
            _of(motion),
        )
        return motion

    return run
