"""Single models, stepped by the kernel; and the C of models/ as functions on arrays."""

import ctypes
import functools
import itertools
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.fmi import toolchain
from tests.corpus.fmu import EXPORT
from tests.cosim.single import exposed

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
    """Compile the numerics of models/ with ``probe.c``, which exports them."""
    paths = (MODELS / "numerics").glob("elementary.*"), (MODELS / "numerics").glob("noise.*")
    files = {f"numerics/{path.name}": path.read_text() for path in itertools.chain(*paths)}
    files["probe.c"] = EXPORT + Path(__file__).with_name("probe.c").read_text()
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
