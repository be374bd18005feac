"""The models, each a folder with model.toml and model.c, and the exporter that makes FMUs of them.

The errors are drawn in ``models/errors.py``.
"""

from models.errors import DescriptionError, ModelError, StartValueError, UnknownModel
from models.export.package import build_fmu, load_model, model_names, write_cross_check
from models.export.sources import FmiVersion

__all__ = [
    "DescriptionError",
    "FmiVersion",
    "ModelError",
    "StartValueError",
    "UnknownModel",
    "build_fmu",
    "load_model",
    "model_names",
    "write_cross_check",
]
