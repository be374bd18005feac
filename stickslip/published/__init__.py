"""The paper's learning as published: coarse starts, Table 3, several seeds, and no later step."""

from stickslip.published.readings import READINGS, LearningReading, evaluation_readings
from stickslip.published.study import Published, SeedRun, learn_as_published

__all__ = [
    "READINGS",
    "LearningReading",
    "Published",
    "SeedRun",
    "evaluation_readings",
    "learn_as_published",
]
