"""Estimation from one recording: values, intervals, and identifiability."""

from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.identification.estimation.estimation import Estimation
from stickslip.identification.estimation.learn import learn
from stickslip.identification.estimation.task import CriterionName, LearnSettings, Task
from stickslip.identification.fitting.identifiability import Identifiability
from stickslip.identification.fitting.search import Search

__all__ = [
    "CriterionName", "Estimation", "Identifiability", "LearnSettings", "Search", "Task",
    "candidate_fmus", "learn",
]  # fmt: skip
