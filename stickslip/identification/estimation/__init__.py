"""What a single recording says of a drive: values, intervals, and what it does not show."""

from stickslip.identification.estimation.candidate_fmus import candidate_fmus
from stickslip.identification.estimation.estimation import (
    Estimation,
    JudgeName,
    Task,
)
from stickslip.identification.estimation.learn import learn
from stickslip.identification.fitting.identifiability import Certainty
from stickslip.identification.fitting.search import Search

__all__ = ["Certainty", "Estimation", "JudgeName", "Search", "Task", "candidate_fmus", "learn"]
