"""What a single recording says of a drive: values, intervals, and what it does not show."""

from stickslip.estimation.bench import candidate_fmus
from stickslip.estimation.certainty import Certainty
from stickslip.estimation.estimation import Estimation, JudgeName, Task
from stickslip.estimation.learn import learn
from stickslip.estimation.search import Search

__all__ = ["Certainty", "Estimation", "JudgeName", "Search", "Task", "candidate_fmus", "learn"]
