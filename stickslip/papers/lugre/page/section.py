"""A section of the page of a reproduction."""

from collections.abc import Callable, Mapping

from matplotlib.figure import Figure

from stickslip.evaluation import motions
from stickslip.evaluation.validation import PHASES
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.published import PAPER_COST
from stickslip.papers.lugre.reproduction import BaseResult
from stickslip.presentation.page import Section
from stickslip.servo.axis import LOOP


def section(
    title: str,
    template: str,
    of: BaseResult | None = None,
    figures: Mapping[str, Callable[[], Figure]] | None = None,
    **values: object,
) -> Section:
    """Return the section of a template beside this file, which has the numbers of the paper."""
    return Section(
        title,
        f"papers/lugre/page/{template}.j2",
        figures,
        reproduction=of,
        tables=tables,
        paper=motions,
        LOOP=LOOP,
        PHASES=PHASES,
        PAPER_COST=PAPER_COST,
        **values,
    )
