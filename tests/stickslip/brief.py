"""What makes a learning brief, where a test is about something else than its accuracy."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import pytest

from stickslip.identification.estimation import Search
from stickslip.presentation.page import Picture


def blank(*_):
    return Picture(b"", b"", 89.0)


@contextmanager
def briefly() -> Iterator[pytest.MonkeyPatch]:
    """Search for a short time, try on few drives and small moves, and leave the figures blank."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stickslip.identification.estimation.Search", partial(Search, evaluations=40))
        patch.setattr("stickslip.presentation.page.Picture.of", blank)
        patch.setattr("stickslip.identification.fitting.fit.DRAWS", 1)
        patch.setattr("stickslip.trial.family.SWEPT_MOVES", 2)
        patch.setattr("stickslip.trial.family.SWEPT_CREEPS", (0.3,))
        yield patch
