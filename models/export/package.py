"""From a model's folder to an .fmu file."""

from __future__ import annotations

import hashlib
import io
import os
import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Literal

from models.errors import UnknownModel
from models.export import fmi2, fmi3
from models.export.description import Model, read_model
from models.export.headers import table_header, table_source, variables_header
from toolchain import Platform, host_platform, shared_library, universal, write_whole

FmiVersion = Literal[2, 3]

_MODELS = Path(__file__).parent.parent
_SHARED = ("friction", "numerics")  # C that several models use
_HEADER = {2: "system/fmi2Functions.h", 3: "system/fmi3Functions.h"}
_DESCRIPTION = {2: fmi2.model_description, 3: fmi3.model_description}
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same bytes from the same sources


def model_names() -> list[str]:
    """Return the names of all models: the folders that have a model.toml."""
    return sorted(path.parent.name for path in _MODELS.glob("*/model.toml"))


def load_model(name: str) -> Model:
    """Read a model by name.

    Raises
    ------
    UnknownModel
        When there is no such model.
    DescriptionError
        When its model.toml is not well formed.
    """
    if name not in model_names():
        raise UnknownModel(f"there is no model '{name}'; there are {', '.join(model_names())}")
    return read_model(_MODELS / name)


def build_fmu(
    name: str,
    folder: Path | str,
    *,
    fmi: FmiVersion = 2,
    platforms: Iterable[Platform] | None = None,
    start: Mapping[str, float] | None = None,
) -> Path:
    """Write ``folder/name.fmu`` and return its path.

    Parameters
    ----------
    name : a model of ``model_names()``
    folder : is made if it is absent
    fmi : version of the standard
    platforms : what to build for; this machine by default
    start : parameter -> start value, in the unit of model.toml, instead of the one there

    Raises
    ------
    UnknownModel, StartValueError
    toolchain.ToolchainError
        When the C does not compile.
    OSError
        When the file cannot be written.
    """
    model = load_model(name).with_start(start or {})
    token = _token(model, fmi)
    files = _sources(model, fmi) | {"table.h": table_header(model, token)} | _fmi_headers()
    members: dict[str, bytes] = {
        "modelDescription.xml": _DESCRIPTION[fmi](model, token).encode(),
    }
    members |= _binaries(name, files, fmi, list(platforms or [host_platform()]))
    return write_whole(Path(folder) / f"{name}.fmu", _archive(members))


def _binaries(
    name: str, files: Mapping[str, str], fmi: FmiVersion, platforms: Sequence[Platform]
) -> dict[str, bytes]:
    """Return the libraries by path in the FMU."""

    def build(platform: Platform) -> Path:
        # A fixed interface has parameters that not every model needs.
        return shared_library(
            name,
            files,
            platform=platform,
            flags=["-Wno-unused-parameter"],
            standalone=True,
            exports=functions,
        )

    functions = re.findall(r"^ *FMI._Export +\w+ +(\w+);", files[_HEADER[fmi]], re.MULTILINE)
    parts: dict[str, list[bytes]] = {}
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        for platform, library in zip(platforms, pool.map(build, platforms), strict=True):
            folder = platform.fmi2 if fmi == 2 else platform.tuple
            parts.setdefault(f"binaries/{folder}/{library.name}", []).append(library.read_bytes())
    return {path: universal(libraries) for path, libraries in parts.items()}


def _sources(model: Model, fmi: FmiVersion) -> dict[str, str]:
    """Return the C files of an FMU by path in the source tree, all but the token's header."""
    files = {
        path.name: _text(path)
        for path in sorted((_MODELS / "adapter").glob("*.[ch]"))
        if not path.name.startswith(f"fmi{5 - fmi}")  # the other standard
    }
    for room in _SHARED:
        for path in sorted((_MODELS / room).glob("*.[ch]")):
            files[f"{room}/{path.name}"] = _text(path)
    return files | {
        "model.c": _text(model.folder / "model.c"),
        "variables.h": variables_header(model),
        "table.c": table_source(model),
    }


def _token(model: Model, fmi: FmiVersion) -> str:
    """Return the hash of sources and description: the same sources, the same FMU."""
    digest = hashlib.sha256(_DESCRIPTION[fmi](model, "").encode())
    for path, content in sorted(_sources(model, fmi).items()):
        digest.update(f"\0{path}\0{content}".encode())
    return digest.hexdigest()[:32]


@cache
def _fmi_headers() -> dict[str, str]:
    """Return the headers of the FMI project, which FMPy's wheel carries."""
    folder = resources.files("fmpy") / "c-code"
    return {
        f"system/{entry.name}": entry.read_text(encoding="utf-8")
        for entry in folder.iterdir()
        if entry.name.startswith(("fmi2", "fmi3"))
    }


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _archive(members: Mapping[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(members.items()):
            info = zipfile.ZipInfo(name, _EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            archive.writestr(info, content)
    return stream.getvalue()
