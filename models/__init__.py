"""Friction laws, plants, compensators and controllers, and the exporter that makes FMUs of them."""

from stickslip.models.errors import (
    DescriptionError,
    LtiError,
    ModelError,
    StartValueError,
    UnknownLaw,
    UnknownModel,
)
from stickslip.models.export.description import Model, Ports
from stickslip.models.export.law import Law, LawParameter
from stickslip.models.export.package import (
    blank_library,
    build_fmu,
    law_names,
    load_law,
    load_model,
    model_names,
    model_of,
)
from stickslip.models.export.sources import FmiVersion
from stickslip.models.lti.package import export_lti
from stickslip.models.lti.system import LinearSystem

__all__ = [
    "DescriptionError",
    "FmiVersion",
    "Law",
    "LawParameter",
    "LinearSystem",
    "LtiError",
    "Model",
    "ModelError",
    "Ports",
    "StartValueError",
    "UnknownLaw",
    "UnknownModel",
    "blank_library",
    "build_fmu",
    "export_lti",
    "law_names",
    "load_law",
    "load_model",
    "model_names",
    "model_of",
]
