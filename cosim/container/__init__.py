"""A whole system as one FMU: its FMUs in the resources, and the kernel as the binary."""

from __future__ import annotations

import hashlib
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Literal

from stickslip.cosim import kernel
from stickslip.cosim.assembly.plan import Layout
from stickslip.cosim.assembly.wiring import wire
from stickslip.cosim.container.description import (
    index,
    licences,
    model_description,
    shown_variables,
)
from stickslip.cosim.container.tables import system_header
from stickslip.cosim.errors import ConnectionFault, ExperimentError, FmuError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.library import UnloadedLibrary
from stickslip.cosim.kernel import unroll
from stickslip.cosim.system.loops import algebraic_loop, group
from stickslip.cosim.system.settings import Coupling, Record
from stickslip.cosim.system.system import System
from stickslip.fmi import toolchain
from stickslip.fmi.archive import zipped
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.files import atomic_write
from stickslip.fmi.standard import standard_files
from stickslip.fmi.toolchain import Platform

_KERNEL = ["kernel.h", "arithmetic.h", "mark.h", "calls.h", "walk.h", "steps.h", "instance.c"]


def write_fmu(
    system: System,
    path: str | os.PathLike[str],
    *,
    step: float,
    fmi: Literal[2, 3] = 2,
    coupling: Literal["gauss_seidel", "jacobi"] = "gauss_seidel",
    outputs: Sequence[str] | None = None,
    parameters: Sequence[str] | None = None,
    experiment: DefaultExperiment | None = None,
    platforms: Iterable[Platform | str] | str | None = None,
) -> Path:
    """Write a system as one FMU for Co-Simulation and return its path.

    It gives the values that a simulation with the same step and coupling gives, bit for bit,
    where the communication steps are multiples of ``step``. In others the last step is shortened
    where all components can vary theirs; else they are refused.

    Parameters
    ----------
    path : of the ``.fmu`` file
    step : of the components, s
    fmi : version of the standard; those of the components may differ from it
    outputs, parameters : names or patterns (``drive.*``) of what the FMU shows of its components;
        by default the outputs of the system, or of all components, and all parameters
    experiment : the times it proposes
    platforms : what to build for, such as ``all``; this machine by default. Each component must
        have a binary there

    Raises
    ------
    ConnectionFault, ParameterError, ExperimentError, FmuError : when the system has what a
        container cannot hold: a component of FMI 1.0, by Model Exchange, with an event mode,
        with arrays, or with signals that are no 64-bit floating-point numbers; algebraic loops
    toolchain.ToolchainError
    OSError : when the file cannot be written
    """
    if not 0 < step < math.inf:
        raise ExperimentError(f"step is {step} s, expected a positive number")
    if fmi not in (2, 3):
        raise ExperimentError(f"fmi is {fmi!r}, expected 2 or 3")
    if coupling not in ("gauss_seidel", "jacobi"):
        what = "expected 'gauss_seidel' or 'jacobi': a container repeats no steps"
        raise ExperimentError(f"coupling is {coupling!r}, {what}")
    components = system.fmus("a container")
    if not components:
        raise ConnectionFault(f"{system.name} has no component; add one before it is exported")
    labels = {name: f"{system.name}: {name} ({fmu.path.name})" for name, fmu in components.items()}
    for name, fmu in components.items():
        _check(fmu, labels[name])
    targets = toolchain.chosen_platforms(platforms)
    if loop := algebraic_loop(system, system.components):
        raise ConnectionFault(
            f"{system.name}: algebraic loop {' -> '.join(loop)}, which a container does not solve;"
            " break it with a component that does not pass its input on at once"
        )
    groups = group(system, Coupling(method=coupling))
    order = [name for g in groups for name in g.components]
    shown = shown_variables(system, outputs, parameters)
    layout = Layout.of(system, Record([v.source for v in shown if v.role == "OUTPUT"]))
    libraries = {name: UnloadedLibrary(fmu) for name, fmu in components.items()}
    jacobi = coupling == "jacobi"
    run, general = wire(system, layout, order, libraries, jacobi=jacobi, tolerance=None)
    folders = _folders(components)
    for name in general:
        raise FmuError(
            f"{labels[name]} cannot go into a container: it needs Model Exchange, events, arrays or"
            " signals other than 64-bit floating-point numbers; leave it in a package of SSP"
        )
    header = system_header(system, run, order, layout, shown, folders, step)
    identifier = re.sub(r"\W", "_", system.name, flags=re.ASCII)
    identifier = identifier if re.match(r"[A-Za-z_]", identifier) else f"_{identifier}"
    times = experiment or DefaultExperiment()
    fmus = components.values()
    for fmu in fmus:
        fmu.restore()

    def described(token: str) -> str:
        return model_description(
            fmi,
            system.name,
            identifier,
            token,
            shown,
            DefaultExperiment(times.start, times.stop, step, times.tolerance),
            varies_step=all(fmu.varies_step for fmu in fmus),
            restores_state=all(fmu.restores_state for fmu in fmus),
            serializes=all(fmu.serializes and fmu.restores_state for fmu in fmus),
        )

    sources = _sources(fmi, _KERNEL)
    if unrolled := unroll(run):
        sources["steps.h"] = unrolled
    content = repr([described(""), header, *sources.values()])
    token = hashlib.sha256(content.encode()).hexdigest()[:32]
    sources["system.h"] = f'#define TOKEN "{token}"\n{header}\n'
    members = {
        "modelDescription.xml": described(token).encode(),
        "documentation/index.html": index(system, order, step, jacobi=jacobi).encode(),
        "documentation/licenses/license.txt": licences(system).encode(),
    }
    inside: dict[str, bytes] = {}
    for name, folder in folders.items():
        inside |= _component(components[name], labels[name], folder, targets)
    members |= _binaries(identifier, sources, fmi, targets) | inside
    return atomic_write(Path(path), zipped(members))


def _check(fmu: Fmu, label: str) -> None:
    if fmu.description.standard == 1:
        what = "is of FMI 1.0; export the model again for FMI 2.0 or 3.0"
    elif fmu.structural:
        what = f"has the structural parameter {fmu.structural[0]}; export it with fixed dimensions"
    else:
        return
    raise FmuError(f"{label} cannot go into a container: it {what}")


def _binaries(
    name: str, sources: Mapping[str, str], fmi: int, targets: Iterable[Platform]
) -> dict[str, bytes]:
    """Return the libraries by path in the FMU."""
    functions = toolchain.standard_functions(sources[f"system/fmi{fmi}Functions.h"])

    def build(target: Platform) -> Path:
        flags = ["-DEXPORT=", "-Wno-unused-parameter"]
        flags += ["-ldl"] if target.suffix == ".so" else []
        return toolchain.shared_library(
            name, sources, platform=target, flags=flags, exports=functions, loads=True
        )

    return toolchain.binaries(name, fmi, targets, build)


def _folders(components: Mapping[str, Fmu]) -> dict[str, str]:
    """Return component -> folder in the resources, one for each FMU."""
    names: dict[Path, str] = {}
    for fmu in components.values():
        plain = re.sub(r"\W", "_", fmu.path.stem, flags=re.ASCII)
        names.setdefault(fmu.folder, f"{len(names)}_{plain}")
    return {name: names[fmu.folder] for name, fmu in components.items()}


def _component(fmu: Fmu, label: str, folder: str, targets: Sequence[Platform]) -> dict[str, bytes]:
    """Return the files of an FMU that a container needs."""
    kept = ["modelDescription.xml", "resources/**/*", "documentation/licenses/**/*"]
    for target in targets:
        place = target.fmi2 if fmu.version == 2 else target.tuple
        if not (fmu.folder / "binaries" / place / (fmu.binary.stem + target.suffix)).is_file():
            advice = "build it for that platform, or leave the platform out"
            raise FmuError(f"{label} has no binary for {target.tuple} (binaries/{place}); {advice}")
        kept.append(f"binaries/{place}/**/*")
    files = sorted(file for pattern in kept for file in fmu.folder.glob(pattern) if file.is_file())
    paths = ((file.relative_to(fmu.folder).as_posix(), file) for file in files)
    return {f"resources/{folder}/{path}": file.read_bytes() for path, file in paths}


def _sources(fmi: int, wanted: Iterable[str]) -> dict[str, str]:
    kernel_files = Path(kernel.__file__).parent
    faces = Path(toolchain.__file__).parents[1] / "faces"
    headers = standard_files("c-code").glob("fmi[23]*.h")
    own = [*Path(__file__).parent.glob("*.[ch]"), *faces.glob("*.[ch]")]
    files = {
        file.name: file
        for file in [*own, *(kernel_files / name for name in wanted)]
        if not file.name.startswith(f"fmi{5 - fmi}")  # the other standard
    }
    files |= {f"system/{file.name}": file for file in headers}
    return {name: file.read_text(encoding="utf-8") for name, file in sorted(files.items())}
