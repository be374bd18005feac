"""Every model as FMI 2.0 and FMI 3.0, driven through FMPy: what another tool sees."""

from __future__ import annotations

import ctypes
import functools
import math
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import fmi2, fmi3
from fmpy.logging import addLoggerProxy

from stickslip import models

STEP = 5e-4  # s


def load(target: str) -> models.Model:
    """Return the description of ``stage`` or, with another law, of ``stage+gms``."""
    name, _, law = target.partition("+")
    return models.load_model(name, law or None)


OTHER_LAWS = [
    f"{name}+{law}"
    for name in models.model_names()
    for law in models.law_names()
    if (own := load(name).law) and law != own.name
]


def cases(versions: Sequence[int | None], *, in_turn: bool = False) -> list[Any]:
    """Return a parameter for each target and version; further cases are thorough.

    Another law is tried in one plant and one compensator; a model in both versions or in turn.
    """
    with_a_law = {"stage": (None, 3), "compensator": (None, 2)}
    every = []
    for k, target in enumerate(models.model_names() + OTHER_LAWS):
        for version in versions:
            own = not in_turn or version == 2 + k % 2
            usual = (
                version in with_a_law.get(target.partition("+")[0], ()) if "+" in target else own
            )
            marks = () if usual else pytest.mark.thorough
            name = f"{target}-fmi{version}" if version else target
            every.append(pytest.param((target, version), id=name, marks=marks))
    return every


class Fmu:
    """A built model: ``model`` as model.toml tells it, ``description`` as FMPy reads it."""

    def __init__(self, path: Path, version: int, target: str) -> None:
        self.path, self.version, self.target = path, version, target
        self.model = load(target)
        self.folder = path.with_suffix("")
        if not self.folder.exists():
            with zipfile.ZipFile(path) as archive:
                archive.extractall(self.folder)
        self.description = fmpy.read_model_description(self.folder)
        self.variables = {v.name: v for v in self.description.modelVariables}

    @property
    def listed(self) -> dict[int, Any]:
        """Value reference -> variable of model.toml: all, but FMI 2.0 does not ask for time."""
        return {
            k: v
            for k, v in enumerate(self.model.variables)
            if self.version == 3 or v.role != "time"
        }

    def names(self, *roles: str) -> list[str]:
        """Return the variables with these roles in model.toml; outputs by their causality."""
        return [
            v.name
            for v in self.model.variables
            if v.role in roles or ("output" in roles and v.is_output)
        ]

    def settings(self) -> dict[str, float]:
        """Return parameters that turn everything on that a model has."""
        values = {"boolean": 1.0, "integer": 3.0}
        return {
            v.name: values[v.type]
            for v in self.model.variables
            if v.role == "parameter" and v.type in values
        }

    def sizes(self) -> dict[str, float]:
        """Return how far to move each input; positions little, for their speed is what counts."""
        return {
            v.name: (v.nominal or 1.0) * (1e-3 if v.unit == "m" else 1.0)
            for v in self.model.variables
            if v.role == "input"
        }

    def inputs(self, n: int) -> dict[str, float]:
        """Return inputs for step n that move everything, a different way each."""
        return {
            name: size * (math.sin(0.05 * (k + 1) * n + k) + 0.3 * (n % 3))
            for k, (name, size) in enumerate(self.sizes().items())
        }

    def points(self, count: int) -> Iterator[dict[str, float]]:
        """Yield inputs and states as large as their nominals and down to a tenthousandth."""
        rng = np.random.default_rng(7)
        chosen = [v for v in self.model.variables if v.role in ("input", "state") and v.nominal]
        for k in range(count):
            scale = 10.0 ** -(k % 5)
            yield {v.name: scale * v.nominal * rng.standard_normal() for v in chosen}


class Slave:
    """One instance with the same face for FMI 2.0 and FMI 3.0.

    Calls raise FMPy's FMICallException where the FMU does not answer OK; ``messages`` are what
    it logged, as (status, category, text). FMPy has one logger for all FMUs of FMI 2.0, so theirs
    go to the instance made last.
    """

    def __init__(
        self,
        fmu: Fmu,
        guid: str | None = None,
        logging: bool = False,
        messages: list[tuple[int, str, str]] | None = None,
        exchange: bool = False,
    ) -> None:
        self.fmu = fmu
        self.messages = [] if messages is None else messages
        description = fmu.description
        arguments = {
            "guid": guid or description.guid or description.instantiationToken,
            "modelIdentifier": description.modelName,
            "unzipDirectory": str(fmu.folder),
            "instanceName": "slave",
        }
        if fmu.version == 2:
            self.api: Any = (fmi2.FMU2Model if exchange else fmi2.FMU2Slave)(**arguments)
            callbacks = fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._log)
            addLoggerProxy(ctypes.byref(callbacks))
            self.api.instantiate(callbacks=callbacks, loggingOn=logging)
        else:
            self.api = (fmi3.FMU3Model if exchange else fmi3.FMU3Slave)(**arguments)
            self.api.instantiate(logMessage=self._log, loggingOn=logging)

    def _log(self, *told: Any) -> None:
        """Keep status, category and text, which come last; FMI 2.0 names the instance before."""
        status, category, text = told[-3:]
        self.messages.append((status, category.decode(), text.decode()))

    def initialize(self, settings: Mapping[str, float] | None = None, start: float = 0.0) -> Slave:
        self.set(settings or {})
        if self.fmu.version == 2:
            self.api.setupExperiment(startTime=start)
            self.api.enterInitializationMode()
        else:
            self.api.enterInitializationMode(startTime=start)
        self.api.exitInitializationMode()
        return self

    def set(self, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            variable = self.fmu.variables[name]
            convert = float if variable.type in ("Real", "Float64") else int
            setter = getattr(self.api, f"set{variable.type}")
            setter([variable.valueReference], [convert(value)])

    def get(self, names: Sequence[str]) -> list[float]:
        """Return values, fetched type by type."""
        found = {}
        for kind in {self.fmu.variables[name].type for name in names}:
            members = [name for name in names if self.fmu.variables[name].type == kind]
            references = [self.fmu.variables[name].valueReference for name in members]
            values = getattr(self.api, f"get{kind}")(references)
            found |= dict(zip(members, values, strict=True))
        return [found[name] for name in names]

    def everything(self) -> list[float]:
        return self.get(list(self.fmu.variables))

    def run(self, first: int, last: int, h: float = STEP) -> np.ndarray:
        """Step n = first .. last - 1 with the inputs of n; return everything after each step."""
        rows = []
        for n in range(first, last):
            self.set(self.fmu.inputs(n))
            self.api.doStep(n * h, (n + 1) * h - n * h)
            rows.append(self.everything())
        return np.array(rows, dtype=float)


class Exchanged(Slave):
    """One instance for Model Exchange, moved by the tests in place of a solver."""

    def __init__(self, fmu: Fmu, **options: Any) -> None:
        super().__init__(fmu, exchange=True, **options)
        self.n_states = len(fmu.names("derivative"))

    def updated(self) -> dict[str, Any]:
        """Update once in event mode; return what was reported, the time of the next event last."""
        kind = "new" if self.fmu.version == 2 else "update"
        reported = getattr(self.api, f"{kind}DiscreteStates")()
        names = ("again", "ends", "nominals", "states", "timed", "time")
        return dict(zip(names, reported, strict=True))

    def place(self, time: float, states: Sequence[float]) -> None:
        """Set time and states in continuous-time mode."""
        self.api.setTime(time)
        self.vector("Derivatives")  # those of the states before
        self.api.setContinuousStates(_pointer(np.array(states, dtype=float)), self.n_states)

    def vector(self, name: str) -> np.ndarray:
        """Return states, derivatives or nominals: ``ContinuousStates`` or ``Derivatives``..."""
        if self.fmu.version == 3 and name == "Derivatives":
            name = "ContinuousStateDerivatives"
        values = np.empty(self.n_states)
        getattr(self.api, f"get{name}")(_pointer(values), self.n_states)
        return values


def _pointer(array: np.ndarray) -> object:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def same_bits(a: object, b: object) -> bool:
    return np.asarray(a, dtype=float).tobytes() == np.asarray(b, dtype=float).tobytes()


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int], Fmu]:
    """Build a model once: ``build("stage", 3)``, with another law ``build("stage+gms", 3)``."""
    folder = tmp_path_factory.mktemp("built")
    built: dict[tuple[str, int], Fmu] = {}

    def build(name: str, version: int) -> Fmu:
        if (name, version) not in built:
            model, _, law = name.partition("+")
            into = folder / f"fmi{version}" / law
            path = models.build_fmu(model, into, fmi=version, law=law or None)
            built[name, version] = Fmu(path, version, name)
        return built[name, version]

    return build


@pytest.fixture(params=cases([None]))
def name(request: pytest.FixtureRequest) -> str:
    """Name each model, and each with every friction law that is not its default, in turn."""
    return request.param[0]


@pytest.fixture(params=cases([2, 3]))
def fmu(request: pytest.FixtureRequest, build: Callable[[str, int], Fmu]) -> Fmu:
    """Give every model in both versions of the standard."""
    return build(*request.param)


@pytest.fixture(params=cases([2, 3], in_turn=True))
def some_fmu(request: pytest.FixtureRequest, build: Callable[[str, int], Fmu]) -> Fmu:
    """Give every model in one version, for tests that take long."""
    return build(*request.param)


@pytest.fixture
def slave() -> Iterator[Callable[..., Slave]]:
    """Instantiate: ``slave(fmu)``; freed after the test."""
    made: list[Slave] = []

    def slave(fmu: Fmu, face: type[Slave] = Slave, **options: Any) -> Slave:
        made.append(face(fmu, **options))
        return made[-1]

    yield slave
    for each in made:
        each.api.freeInstance()


@pytest.fixture
def exchanged(slave: Callable[..., Slave]) -> Callable[..., Exchanged]:
    """Instantiate for Model Exchange: ``exchanged(fmu)``; freed after the test."""
    return functools.partial(slave, face=Exchanged)


@pytest.fixture
def identical() -> Callable[[object, object], bool]:
    """Compare two arrays by their bits."""
    return same_bits
