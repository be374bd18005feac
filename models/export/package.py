"""From a model's folder to an .fmu file."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from stickslip.fmi.toolchain import (
    Platform,
    binaries,
    host_platform,
    shared_library,
    standard_functions,
    write_whole,
)
from stickslip.models.errors import UnknownModel
from stickslip.models.export import (
    fmi2,
    fmi3,
    icon,
)
from stickslip.models.export.description import Model, read_model
from stickslip.models.export.documentation import index
from stickslip.models.export.headers import table_header
from stickslip.models.export.reference import cross_check, layered_standard
from stickslip.models.export.sources import (
    COMPILER_OPTIONS,
    MODELS,
    FmiVersion,
    build_description,
    c_files,
    fmi_headers,
    grouped,
    text,
)
from stickslip.models.export.terminals import terminals_and_icons

_ICON = {2: "model.png", 3: "terminalsAndIcons/icon.png"}
_DESCRIPTION = {2: fmi2.model_description, 3: fmi3.model_description}
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same bytes from the same sources


def model_names() -> list[str]:
    """Return the names of all models: the folders that have a model.toml."""
    return sorted(path.parent.name for path in MODELS.glob("*/model.toml"))


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
    return read_model(MODELS / name)


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
    # What is expected is so for the start values of model.toml.
    return pack_fmu(model, folder, fmi=fmi, platforms=platforms, reference=not start)


def pack_fmu(
    model: Model,
    folder: Path | str,
    *,
    fmi: FmiVersion = 2,
    platforms: Iterable[Platform] | None = None,
    reference: bool = False,
) -> Path:
    """Write ``folder/NAME.fmu`` of any model and return its path.

    ``model.folder`` has its C and README.md. With ``reference`` its reference.csv goes inside. The
    rest is as for ``build_fmu``.
    """
    token = _token(model, fmi)
    files = c_files(model, fmi) | {"table.h": table_header(model, token)}
    texts = {
        "modelDescription.xml": _DESCRIPTION[fmi](model, token),
        "documentation/index.html": index(model, _ICON[fmi]),
        "documentation/licenses/license.txt": text(MODELS / "license.txt"),
        "terminalsAndIcons/terminalsAndIcons.xml": terminals_and_icons(model),
        "terminalsAndIcons/icon.svg": icon.svg(model.icon),
        "sources/buildDescription.xml": build_description(model, files),
        **{f"sources/{path}": content for path, content in files.items()},
    }
    if fmi == 2:  # FMI 3.0 does not want its headers inside
        texts |= {f"sources/{path}": content for path, content in fmi_headers(fmi).items()}
    if reference:
        texts |= layered_standard(model)
    members = {path: content.encode() for path, content in texts.items()}
    members |= dict.fromkeys({"terminalsAndIcons/icon.png", _ICON[fmi]}, icon.png(model.icon))
    members |= _binaries(model.name, files, fmi, platforms or [host_platform()])
    return write_whole(Path(folder) / f"{model.name}.fmu", _archive(members))


def write_cross_check(name: str, folder: Path | str) -> list[Path]:
    """Write what the FMI Cross-Check wants beside an FMU: inputs, expected outputs, options.

    Raises
    ------
    UnknownModel
    OSError
        When a file cannot be written.
    """
    files = cross_check(load_model(name))
    return [write_whole(Path(folder) / path, content) for path, content in files.items()]


def _binaries(
    name: str, files: dict[str, str], fmi: FmiVersion, platforms: Iterable[Platform]
) -> dict[str, bytes]:
    """Return the libraries by path in the FMU."""
    headers = fmi_headers(fmi)
    files = grouped(files) | {f"system/{path}": content for path, content in headers.items()}
    functions = standard_functions(headers[f"fmi{fmi}Functions.h"])

    def build(platform: Platform) -> Path:
        # A fixed interface has parameters that not every model needs.
        return shared_library(
            name,
            files,
            platform=platform,
            flags=["-Wno-unused-parameter", *COMPILER_OPTIONS.split()],
            standalone=True,
            exports=functions,
        )

    return binaries(fmi, platforms, build)


def _token(model: Model, fmi: FmiVersion) -> str:
    """Return the hash of sources and description: the same sources, the same FMU."""
    digest = hashlib.sha256(_DESCRIPTION[fmi](model, "").encode())
    for path, content in sorted(c_files(model, fmi).items()):
        digest.update(f"\0{path}\0{content}".encode())
    return digest.hexdigest()[:32]


def _archive(members: Mapping[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(members.items()):
            info = zipfile.ZipInfo(name, _EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            archive.writestr(info, content)
    return stream.getvalue()
