"""What makes a learning brief, where a test is about something else than its accuracy."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module

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
        for room in ("estimation.learn", "selection.prediction"):
            patch.setattr(import_module(f"stickslip.identification.{room}"), "DRAWS", 1)
        patch.setattr("stickslip.trial.family.SWEPT_MOVES", 2)
        patch.setattr("stickslip.trial.family.SWEPT_CREEPS", (0.3,))
        yield patch
