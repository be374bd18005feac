"""The ring: three FMUs of a few operations each, or three times as many."""

from pathlib import Path

from stickslip import cosim
from tests.corpus import fmu

HERE = Path(__file__).parent
STEP = 1e-4
MODELS = {
    "controller": ["y input 0", "u output 0", "I local 0", "r parameter 0.2",
                   "K_p parameter 40", "K_i parameter 900"],
    "mass": ["u input 0", "f input 0", "v output 0", "x output 0", "m parameter 2",
             "d parameter 0.1"],
    "friction": ["v input 0", "f output 0", "c parameter 1.5", "z local 0"],
}  # fmt: skip
FEEDS = {
    "controller.u": "mass.u",
    "friction.f": "mass.f",
    "mass.v": ("controller.y", "friction.v"),
}


def system(folder: Path, version: int, n: int = 3, extra: int = 0) -> cosim.System:
    """Return a ring of n FMUs, n / 3 times the three models; ``extra`` outputs each, FMI 2.0."""
    fmus = {name: cosim.Fmu(build(folder, name, version, extra)) for name in MODELS}
    ring = cosim.System("ring")
    for i in range(n // 3):
        for name in MODELS:
            ring.add(_component(name, i), fmus[name])
    for i in range(n // 3):
        ring.connect(_component("controller", i, "u"), _component("mass", i, "u"))
        ring.connect(_component("friction", i, "f"), _component("mass", i, "f"))
        ring.connect(_component("mass", i, "v"), _component("friction", i, "v"))
        after = (i + 1) % (n // 3)
        ring.connect(_component("mass", i, "v"), _component("controller", after, "y"))
    return ring


def build(folder: Path, name: str, version: int, extra: int = 0) -> Path:
    """Write one FMU of FMI 2.0 or 3.0."""
    path = folder / f"fmi{version}-{extra}" / f"{name}.fmu"
    if not path.exists():
        binary = library(name).read_bytes()
        fmu.pack(path, _description(name, version, extra), {fmu.place(name, version): binary})
    return path


def library(name: str) -> Path:
    """Compile one model."""
    flags = (f"-DMODEL_START={name.upper()}_START", f"-DMODEL_STEP=step_{name}")
    return fmu.library(name, HERE / "ring.h", HERE / "ring.c", flags=flags)


def _component(name: str, i: int, variable: str | None = None) -> str:
    component = f"{name}{i}" if i else name
    return f"{component}.{variable}" if variable else component


def _description(name: str, version: int, extra: int) -> str:
    listed = [line.split() for line in MODELS[name]]
    source = next(i for i, (_, kind, _) in enumerate(listed) if kind == "output")
    entries = [(i, *entry) for i, entry in enumerate(listed)]
    entries += [
        (source if version == 2 else fmu.TIME + 1 + i, f"copy[{i}]", "output", "0")
        for i in range(extra)
    ]
    variables = [
        fmu.Variable(
            variable,
            kind,
            start,
            variability="tunable" if kind == "parameter" else "continuous",
            initial=None if kind == "input" else "exact",
            reference=reference,
            depends=() if kind == "output" else None,
        )
        for reference, variable, kind, start in entries
    ]
    ability = 'canHandleVariableCommunicationStepSize="true"'
    return fmu.describe(name, version, variables, {"CoSimulation": ability})
