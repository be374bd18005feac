"""FMUs of ours, which are to be found sound."""

from collections.abc import Callable
from pathlib import Path

import pytest

from stickslip import models

Build = Callable[[str, int], Path]


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """Build a model once: ``build("stage", 3)``, with another law ``build("stage+gms", 3)``."""
    folder = tmp_path_factory.mktemp("sound")

    def build(name: str, version: models.FmiVersion) -> Path:
        path = folder / f"fmi{version}" / f"{name}.fmu"
        if path.exists():
            return path
        model, _, law = name.partition("+")
        return models.build_fmu(model, path.parent / law, fmi=version, law=law or None)

    return build
