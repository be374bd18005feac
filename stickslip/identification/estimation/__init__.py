"""Estimation from one recording: values, intervals, and identifiability."""

from stickslip.identification.estimation.candidate_fmus import candidate_fmus
from stickslip.identification.estimation.estimation import CriterionName, Estimation, Task
from stickslip.identification.estimation.learn import learn
from stickslip.identification.fitting.identifiability import Certainty
from stickslip.identification.fitting.search import Search

__all__ = ["Certainty", "CriterionName", "Estimation", "Search", "Task", "candidate_fmus", "learn"]
