"""The FMUs of one drive, built once."""

import pytest

from stickslip.servo.systems import build_fmus


@pytest.fixture(scope="package")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    build_fmus(folder, {})
    return folder
