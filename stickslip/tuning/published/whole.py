"""The whole study of the paper's learning: all seeds as published, and under other readings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import pandas as pd

from stickslip.fmi.process import Threads
from stickslip.identification.stages import Identification
from stickslip.servo.rig import Rig
from stickslip.servo.systems import Feed
from stickslip.tuning.published.readings import (
    READINGS,
    LearningReading,
    evaluation_readings,
    learning_row,
    threshold_reading,
)
from stickslip.tuning.published.study import Method, Published, learn_as_published

TABLES = ("fitness", "table4", "learned", "readings", "readings_evaluation")
"""The names of the study's tables, as which they are written."""


@dataclass(frozen=True)
class WholeStudy:
    """What came out.

    Attributes
    ----------
    published : our reading, all seeds
    readings : a row for each other reading that learns in another way, see ``learning_row``
    """

    published: Published
    readings: pd.DataFrame

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return all tables by the names of ``TABLES``."""
        published = self.published
        found = (published.fitness(), published.table4(), published.learned())
        return dict(zip(TABLES, (*found, self.readings, self.evaluations), strict=True))

    @property
    def evaluations(self) -> pd.DataFrame:
        """The readings that evaluate the same runs in another way, see ``evaluation_readings``."""
        return evaluation_readings(self.published)

    @property
    def threshold(self) -> dict[str, float]:
        """What a threshold in Step 3 changes, see ``threshold_reading``."""
        return threshold_reading(self.published)


def study_as_published(
    rig: Rig,
    identification: Identification,
    seeds: Sequence[int],
    *,
    reading_seeds: int,
    feed: Feed = "nominal",
    workers: int = 1,
    on_stage: Callable[[str], object] = lambda _: None,
) -> WholeStudy:
    """Learn as published from coarse starts, and again under each other reading.

    Parameters
    ----------
    seeds : of our reading
    reading_seeds : how many of them, the first, learn under each other reading
    feed : what drives the compensator
    """

    def learned(method: Method, chosen: Sequence[int], workers: int) -> Published:
        loop, found = identification.loop, identification.estimates
        return learn_as_published(rig, loop, found, chosen, method, workers)

    on_stage(f"learning as published, {len(seeds)} seeds")
    ours = learned(Method(feed=feed), seeds, workers)
    if reading_seeds:
        on_stage(f"{len(READINGS)} other readings, {reading_seeds} seeds each")

    def row(reading: LearningReading) -> dict[str, object]:
        method = reading.method
        if method.feed == Method.feed:
            method = replace(method, feed=feed)
        return learning_row(reading, ours, learned(method, seeds[:reading_seeds], 1))

    with Threads(workers) as threads:
        rows = threads.each(row, READINGS if reading_seeds else ())
    columns = list(learning_row(READINGS[0], ours, ours))  # a table also where nothing is in it
    return WholeStudy(ours, pd.DataFrame(rows, columns=columns))
