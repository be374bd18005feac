"""From a model's folder to an .fmu file."""

import hashlib
import re
import zipfile
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, get_args

from stickslip.fmi import toolchain
from stickslip.fmi.additions import left_out
from stickslip.fmi.archive import zipped
from stickslip.fmi.by_name import by_name
from stickslip.fmi.files import atomic_write
from stickslip.fmi.messages import suggestion
from stickslip.models.errors import (
    ModelError,
    StartValueError,
    UnknownLaw,
    UnknownModel,
)
from stickslip.models.export import presentation, sources
from stickslip.models.export.description import Model, read_model
from stickslip.models.export.law import MODELS, Law, read_law, read_toml, roots
from stickslip.models.export.model_description import model_description

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_ROOMS = ("plants", "compensators", "controllers")
_ICON = {2: "model.png", 3: "terminalsAndIcons/icon.png"}


@cache
def _folders() -> dict[str, Path]:
    """Return the folder of each model; a model.toml may give another name than its folder's."""
    found = {}
    for room in _ROOMS:
        for path in (path for root in roots() for path in (root / room).glob("*/model.toml")):
            with left_out(path, Exception):
                found[read_toml(path).get("name", path.parent.name)] = path.parent
    return dict(sorted(found.items()))


def model_names() -> list[str]:
    """Return the names of all models: plants, compensators and controllers."""
    return list(_folders())


def law_names() -> list[str]:
    """Return the names of all friction laws: the folders that have a sound law.toml."""
    return list(_law_names())


@cache
def _law_names() -> tuple[str, ...]:
    found = []
    for folder in _law_folders():
        with left_out(folder, Exception):
            found.append(read_law(folder).name)
    return tuple(found)


def _law_folders() -> list[Path]:
    paths = (path for root in roots() for path in (root / "laws").glob("*/law.toml"))
    return sorted((path.parent for path in paths), key=lambda folder: folder.name)


def load_law(name: str) -> Law:
    """Read a friction law by name.

    Raises
    ------
    UnknownLaw, DescriptionError
        When there is no such law, or its law.toml is not well formed.
    """
    folder = next((one for one in _law_folders() if one.name == name), None)
    if folder is None:
        raise UnknownLaw(f"there is no friction law '{name}'{suggestion(name, law_names())}")
    return read_law(folder)


@cache
def load_model(name: str, law: str | None = None) -> Model:
    """Read a model by name.

    Parameters
    ----------
    name : a model of ``model_names()``
    law : a friction law of ``law_names()`` in place of the one that model.toml names

    Raises
    ------
    UnknownModel, DescriptionError
        When there is no such model, or its model.toml or law.toml is not well formed.
    UnknownLaw
        When there is no such law, or the model contains none.
    """
    folder = _folders().get(name)
    if folder is None:
        raise UnknownModel(f"there is no model '{name}'{suggestion(name, model_names())}")
    default = read_toml(folder / "model.toml").get("law")
    if law is not None and default is None:
        raise UnknownLaw(f"model '{name}' contains no friction law, so it cannot have '{law}'")
    chosen = law or default
    return read_model(folder, load_law(chosen) if chosen else None)


def checked_name(name: str) -> str:
    """Return the name of a model; ModelError when files and C cannot have it."""
    if not _IDENTIFIER.fullmatch(name):
        raise ModelError(f"{name!r:.80} cannot name a model: letters, digits and _ only")
    return name


def build_fmu(
    name: str,
    folder: Path | str,
    *,
    fmi: sources.FmiVersion = 2,
    platforms: Iterable[toolchain.Platform | str] | str | None = None,
    start: Mapping[str, float] | None = None,
    law: str | None = None,
    called: str | None = None,
    rotary: bool = False,
    terminals: bool = True,
    note: str = "",
    notes: Sequence[str] = (),
) -> Path:
    """Write ``folder/name.fmu`` and return its path.

    Parameters
    ----------
    name : a model of ``model_names()``
    folder : is made if it is absent
    fmi : version of the standard
    platforms : what to build for, such as ``all``; this machine by default
    start : parameter -> start value, in the unit of model.toml, instead of the one there
    law : a friction law of ``law_names()`` in place of the model's default
    called : name of the file and of the model in it, by default ``name``
    rotary : with the units of a rotary drive
    terminals : with terminalsAndIcons.xml, of which FMI Library says FATAL in FMI 2.0
    note : a sentence without full stop, before the description in the FMU
    notes : lines on where the start values come from, on the page in the FMU

    Raises
    ------
    UnknownModel, UnknownLaw, StartValueError, toolchain.ToolchainError, OSError
    ModelError
        When it cannot have the name, or there is no such version of the standard.
    """
    if fmi not in get_args(sources.FmiVersion):
        raise ModelError(f"fmi is {fmi!r}; expected 2 or 3")
    starts = by_name("start", start, StartValueError)
    model = load_model(name, law).with_start(starts).of_motion(rotary=rotary)
    description = f"{note}. {model.description}" if note else model.description
    model = replace(model, name=checked_name(called or model.name), description=description)
    # The reference holds for the start values of model.toml and law.toml.
    own = not starts and presentation.reference_file(model) is not None
    given: dict[str, Any] = {"fmi": fmi, "platforms": platforms, "terminals": terminals}
    return pack_fmu(model, folder, reference=own, notes=notes, **given)


def pack_fmu(
    model: Model,
    folder: Path | str,
    *,
    fmi: sources.FmiVersion = 2,
    platforms: Iterable[toolchain.Platform | str] | str | None = None,
    reference: bool = False,
    terminals: bool = True,
    notes: Sequence[str] = (),
) -> Path:
    """Write an FMU of any model, as ``build_fmu``, with its reference and return its path."""
    own = sources.c_files(model, fmi)
    token = _token(model, fmi, own)
    values = [float(variable.start) for variable in model.variables]
    files = own | {sources.START: sources.start_source(token, values)}
    texts = {
        "modelDescription.xml": model_description(model, token, fmi),
        "documentation/index.html": presentation.index(model, _ICON[fmi], notes),
        "documentation/licenses/license.txt": sources.text(MODELS / "license.txt"),
        "terminalsAndIcons/terminalsAndIcons.xml": presentation.terminals_and_icons(model),
        "terminalsAndIcons/icon.svg": presentation.svg(model.icon),
        "sources/buildDescription.xml": sources.build_description(model, files),
        **{f"sources/{path}": content for path, content in files.items()},
    }
    if fmi == 2:  # FMI 3.0 does not want its headers inside
        texts |= {f"sources/{path}": content for path, content in sources.fmi_headers(fmi).items()}
    if reference:
        texts |= presentation.layered_standard(model)
    if not terminals:
        del texts["terminalsAndIcons/terminalsAndIcons.xml"]
    members = {path: content.encode() for path, content in texts.items()}
    icon = presentation.png(model.icon)
    members |= dict.fromkeys({"terminalsAndIcons/icon.png", _ICON[fmi]}, icon)
    start = sources.start_bytes(token, values)
    marker = sources.MARKER.encode().ljust(sources.MARKER_SIZE, b"\0")
    members |= toolchain.binaries(
        model.name,
        fmi,
        toolchain.chosen_platforms(platforms),
        lambda platform: blank_library(model, fmi, platform),
        lambda library: toolchain.patched(library, marker, start),
    )
    return atomic_write(Path(folder) / f"{model.name}.fmu", zipped(members))


def model_of(fmu: Path) -> Model | None:
    """Return the model that an FMU was made of, without its start values; None for no such one.

    Its sources tell: sizes and checksums are those of the model's.
    """
    with zipfile.ZipFile(fmu) as file:
        members = [one for one in file.infolist() if one.filename.startswith("sources")]
    own = {one.filename: (one.file_size, one.CRC) for one in members}
    names = [match[1] for path in own if (match := re.match(r"sources/laws/(\w+)/law\.c", path))]
    for name, folder in _folders().items():
        if own.get("sources/model.c") != _sum((folder / "model.c").read_bytes()):
            continue
        model = load_model(name, names[0] if names else None)
        for version in get_args(sources.FmiVersion):
            files = sources.c_files(model, version).items()
            if all(own.get(f"sources/{path}") == _sum(content.encode()) for path, content in files):
                return model
    return None


def _sum(data: bytes) -> tuple[int, int]:
    """Return size and checksum, as the directory of an archive has them."""
    return len(data), zlib.crc32(data)


def blank_library(model: Model, fmi: sources.FmiVersion, platform: toolchain.Platform) -> Path:
    """Return the library of a model, compiled for all names and start values."""
    headers = sources.fmi_headers(fmi)
    blank = sources.start_source("", [0.0] * len(model.variables))
    files, common = sources.grouped(sources.c_files(model, fmi) | {sources.START: blank})
    return toolchain.shared_library(
        "model",
        files | {f"system/{path}": content for path, content in headers.items()},
        common=common,
        platform=platform,
        # A fixed interface has parameters that not every model needs.
        flags=["-Wno-unused-parameter", *sources.COMPILER_OPTIONS.split()],
        standalone=True,
        exports=toolchain.standard_functions(headers[f"fmi{fmi}Functions.h"]),
    )


def _token(model: Model, fmi: sources.FmiVersion, files: Mapping[str, str]) -> str:
    """Return the hash of sources and description: the same sources, the same FMU."""
    digest = hashlib.sha256(model_description(model, "", fmi).encode())
    for path, content in sorted(files.items()):
        digest.update(f"\0{path}\0{content}".encode())
    return digest.hexdigest()[:32]
