"""The paper's learning as published: coarse starts, Table 3, several seeds, and no later step.

    study = study_as_published(rig, identification, seeds=range(20), reading_seeds=5, workers=2)

``study.py`` learns; ``readings.py`` lists what the paper leaves open, and learns under each.
"""

from stickslip.tuning.published.readings import WholeStudy, study_as_published
from stickslip.tuning.published.study import Published, learn_as_published

__all__ = ["Published", "WholeStudy", "learn_as_published", "study_as_published"]
