"""The FMUs of one drive, built once."""

import pytest

from stickslip.models import build_fmu


@pytest.fixture(scope="package")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    for name in ("drive", "velocity_controller", "nominal_loop", "compensator"):
        build_fmu(name, folder)
    return folder
