"""The report: figures good enough for a paper, and one page that explains them.

    report.write_report(reproduction, Path("results/paper"))

A file a figure; sizes, colours and fonts are in ``style.py``, the page in ``page.py``, its
sections in ``section_*.py``. Everything is computed from the reproduction, and the same one gives
the same bytes.
"""

from __future__ import annotations

from pathlib import Path

from stickslip.fmi.files import atomic_write
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.picture import (
    Drawing,
    Picture,
    picture_files,
)
from stickslip.report.reproduction import (
    as_published_pictures,
    fig2,
    fig3,
    fig4,
    fig5,
    fig6,
    fig_motions,
    identification_friction,
    identification_inertia,
    identification_presliding,
    steps_picture,
)
from stickslip.report.reproduction.page import page

__all__ = ["FIGURES", "FILES", "write_report"]

FIGURES: dict[str, Drawing] = {
    "fig2_loops": fig2.draw,
    "fig3_scheme": fig3.draw,
    "fig4_flow": fig4.draw,
    "fig5_fitness": fig5.draw,
    "fig6_tracking": fig6.draw,
    "steps": steps_picture.draw,
    "motions": fig_motions.draw,
    "fig5_as_published": as_published_pictures.draw_fitness,
    "as_published": as_published_pictures.draw_outcomes,
    "identification_inertia": identification_inertia.draw,
    "identification_friction": identification_friction.draw,
    "identification_presliding": identification_presliding.draw,
}
"""The figures by the name of their files."""
NEEDS = {
    "steps": "motions",
    "motions": "motions",
    "fig5_as_published": "published",
    "as_published": "published",
}
"""What of a reproduction a figure needs, where it is not always there."""
FILES = ("report.html", *picture_files(FIGURES))
"""What ``write_report`` writes."""


def write_report(reproduction: Reproduction, folder: Path) -> list[Path]:
    """Write the figures as PNG and SVG, and report.html, which holds the figures itself.

    Parameters
    ----------
    reproduction : what is reported
    folder : is made if it is absent; files of the same names are replaced, each as a whole

    Returns
    -------
    the files written, the page last

    Raises
    ------
    OSError
        When the folder cannot be written.
    """
    pictures = {
        name: Picture.of(draw, reproduction)
        for name, draw in FIGURES.items()
        if getattr(reproduction, NEEDS.get(name, "options")) is not None
    }
    written = []
    for name, picture in pictures.items():
        written.append(atomic_write(folder / f"{name}.png", picture.png))
        written.append(atomic_write(folder / f"{name}.svg", picture.svg))
    written.append(atomic_write(folder / "report.html", page(reproduction, pictures)))
    return written
