"""The C of an FMU, and how it says it is compiled."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree as ET

from stickslip import fmi
from stickslip.fmi.description import writing
from stickslip.fmi.standard import standard_files
from stickslip.models.export.description import Model
from stickslip.models.export.headers import table_header, table_source, variables_header
from stickslip.models.export.law import MODELS

FmiVersion = Literal[2, 3]

FACES = Path(fmi.__file__).parent / "faces"
START = "start.c"  # the token and the start values
# Without fused multiply-add, all compilers give the same bits; scalar equations packed into vectors
# took a tenth more time.
COMPILER_OPTIONS = "-O2 -ffp-contract=off -fno-tree-slp-vectorize"


def text(path: Path) -> str:
    """Return a text file."""
    return path.read_text(encoding="utf-8")


def c_files(model: Model, fmi: FmiVersion) -> dict[str, str]:
    """Return the C files of an FMU by path in the source tree, all but ``START``."""
    files = {
        path.name: text(path)
        for folder in (MODELS / "adapter", FACES)
        for path in sorted(folder.glob("*.[ch]"))
        if not path.name.startswith(f"fmi{5 - fmi}")  # the other standard
    }
    return files | {
        **{path.relative_to(MODELS).as_posix(): text(path) for path in shared_files(model)},
        **{path.name: text(path) for path in sorted(model.folder.glob("*.[ch]"))},
        "variables.h": variables_header(model),
        "table.h": table_header(model),
        "table.c": table_source(model),
    }


def shared_files(model: Model) -> list[Path]:
    """Return the C files that a model has from other rooms: numerics, its law and its motion."""
    files = [*(MODELS / "numerics").glob("*.[ch]"), *model.sources]
    if model.law is not None:
        files += [*(MODELS / "laws").glob("*.h"), *model.law.folder.glob("*.[ch]")]
        if model.folder.parent.name == "plants":
            own = model.law.folder / "motion.c"
            general = MODELS / "plants" / "midpoint.c"
            files += [MODELS / "plants" / "motion.h", *([] if own.exists() else [general])]
        else:
            files = [path for path in files if path.name != "motion.c"]
    return sorted(files)


def compiled(files: Iterable[str]) -> list[str]:
    """Return those that a compiler is called with."""
    return sorted(path for path in files if path.endswith(".c"))


def grouped(files: dict[str, str]) -> dict[str, str]:
    """Return the same C with the adapter in one file, which compiles in half the time."""
    alone = "model.c", START
    adapter = [path for path in compiled(files) if "/" not in path and path not in alone]
    return {f"{path}.inc" if path in adapter else path: text for path, text in files.items()} | {
        "adapter.c": "".join(f'#include "{path}.inc"\n' for path in adapter)
    }


@cache
def fmi_headers(fmi: FmiVersion) -> dict[str, str]:
    """Return the headers of the FMI project by name, which FMPy's wheel carries."""
    return {
        entry.name: entry.read_text(encoding="utf-8")
        for entry in standard_files("c-code").iterdir()
        if entry.name.startswith(f"fmi{fmi}")
    }


def build_description(model: Model, files: Iterable[str]) -> str:
    """Return buildDescription.xml.

    Source
    ------
    FMI 3.0.2, section 2.5.1.2; FMI 2.0.4 takes the same file.
    """
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = writing.child(root, "BuildConfiguration", modelIdentifier=model.name)
    sources = writing.child(
        configuration,
        "SourceFileSet",
        language="C11",
        compiler="gcc",
        compilerOptions=COMPILER_OPTIONS,
    )
    for path in compiled(files):
        writing.child(sources, "SourceFile", name=path)
    writing.child(sources, "IncludeDirectory", name=".")
    return writing.document(root)
