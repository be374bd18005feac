"""The models, each a folder with model.toml and model.c, and the exporter that makes FMUs of them.

The errors are drawn in ``models/errors.py``.
"""

from stickslip.models.errors import (
    DescriptionError,
    LtiError,
    ModelError,
    StartValueError,
    UnknownModel,
)
from stickslip.models.export.package import (
    build_fmu,
    load_model,
    model_names,
    write_cross_check,
)
from stickslip.models.export.sources import FmiVersion
from stickslip.models.lti.file import LtiFile, read_lti
from stickslip.models.lti.package import export_lti
from stickslip.models.lti.system import LinearSystem

__all__ = [
    "DescriptionError",
    "FmiVersion",
    "LinearSystem",
    "LtiError",
    "LtiFile",
    "ModelError",
    "StartValueError",
    "UnknownModel",
    "build_fmu",
    "export_lti",
    "load_model",
    "model_names",
    "read_lti",
    "write_cross_check",
]
