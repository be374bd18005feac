"""Errors of the models package."""

from stickslip.fmi.errors import Fault


class ModelError(Fault):
    """A model cannot be read or built."""


class UnknownModel(ModelError, ValueError):
    """No model of that name exists."""


class UnknownLaw(ModelError, ValueError):
    """No friction law of that name exists, or a model contains none."""


class DescriptionError(ModelError, ValueError):
    """A model.toml or law.toml is not well formed; the message names file, variable and key."""


class StartValueError(ModelError, ValueError):
    """A start value cannot be set."""


class LtiError(ModelError, ValueError):
    """A linear system cannot be an FMU, or a file does not describe one."""
