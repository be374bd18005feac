"""What a single recording says of a drive: values, intervals, and what it does not show."""

from stickslip.estimation.bench import candidate_fmus
from stickslip.estimation.certainty import Certainty
from stickslip.estimation.learn import Estimation, Task, learn

__all__ = ["Certainty", "Estimation", "Task", "candidate_fmus", "learn"]
