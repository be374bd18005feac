"""Errors of the learning; the tree is drawn in ``ga/__init__.py``."""


class GaError(Exception):
    """Something about a learning run is wrong."""


class SettingsError(GaError, ValueError):
    """A gene, a setting or a repair makes no sense."""


class CostError(GaError, ValueError):
    """Costs told to the algorithm do not fit the candidates it asked about."""


class StateError(GaError, ValueError):
    """A checkpoint belongs to another problem, or is no checkpoint."""


class CallOrderError(GaError, RuntimeError):
    """``ask`` and ``tell`` were called out of turn."""


class CandidateFailed(GaError):
    """A candidate cannot be judged: it costs infinity, and its message is the recorded reason."""


class NothingLearned(GaError):
    """Every candidate of the first generation failed. The message gives the first reason."""
