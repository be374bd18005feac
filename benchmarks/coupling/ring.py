"""The ring: three FMUs of a few operations each, or three times as many."""

import re
import zipfile
from pathlib import Path

import fmpy

from stickslip import cosim
from stickslip.fmi import toolchain

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
        path.parent.mkdir(parents=True, exist_ok=True)
        platform = toolchain.host_platform()
        place = platform.fmi2 if version == 2 else platform.tuple
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", _description(name, version, extra))
            archive.write(library(name), f"binaries/{place}/{name}{platform.suffix}")
    return path


def library(name: str) -> Path:
    """Compile one model."""
    files = headers() | {file: (HERE / file).read_text() for file in ("ring.h", "ring.c")}
    declared = re.findall(r"FMI[23]_Export fmi[23]\w+TYPE\s+(\w+);", "".join(files.values()))
    unused = sorted({call for call in declared if f"{call}(" not in files["ring.c"]})
    export = '__attribute__((visibility("default"))) int'
    files["unused.c"] = "".join(f"{export} {call}(void) {{ return 3; }}\n" for call in unused)
    flags = (f"-DSTART={name.upper()}_START", f"-DSTEP=step_{name}")
    return toolchain.shared_library(name, files, flags=flags)


def headers() -> dict[str, str]:
    folder = Path(fmpy.__file__).parent / "c-code"
    return {f"system/{file.name}": file.read_text() for file in folder.glob("fmi[23]*.h")}


def _component(name: str, i: int, variable: str | None = None) -> str:
    component = f"{name}{i}" if i else name
    return f"{component}.{variable}" if variable else component


def _description(name: str, version: int, extra: int) -> str:
    listed = [line.split() for line in MODELS[name]]
    source = next(i for i, (_, kind, _) in enumerate(listed) if kind == "output")
    variables, outputs = [], []
    entries = [(i, *entry) for i, entry in enumerate(listed)]
    entries += [
        (source if version == 2 else len(listed) + i, f"copy[{i}]", "output", "0")
        for i in range(extra)
    ]
    for place, (reference, variable, kind, start) in enumerate(entries, 1):
        changes = "tunable" if kind == "parameter" else "continuous"
        exact = "" if kind == "input" else ' initial="exact"'
        common = (
            f'name="{variable}" valueReference="{reference}" causality="{kind}"'
            f' variability="{changes}"{exact}'
        )
        if version == 2:
            variables.append(f'<ScalarVariable {common}><Real start="{start}"/></ScalarVariable>')
        else:
            variables.append(f'<Float64 {common} start="{start}"/>')
        if kind == "output" and version == 2:
            outputs.append(f'<Unknown index="{place}" dependencies=""/>')
        elif kind == "output":
            outputs.append(f'<Output valueReference="{reference}" dependencies=""/>')
    token = "guid" if version == 2 else "instantiationToken"
    structure = f"<Outputs>{''.join(outputs)}</Outputs>" if version == 2 else "".join(outputs)
    ability = "canHandleVariableCommunicationStepSize"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<fmiModelDescription fmiVersion="{version}.0" modelName="{name}" {token}="{name}">'
        f'<CoSimulation modelIdentifier="{name}" {ability}="true"/>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
