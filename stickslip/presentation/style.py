"""How figures look: sizes, colours and fonts for a printed column.

Colours differ in lightness as well as in hue (orange against blue), so they survive greyscale and
the common kinds of colour-blindness. Fonts ship with matplotlib: figures look the same everywhere.
"""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from threading import Lock
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

COLUMN = 89.0  # Width of one column [mm]
PAGE = 183.0  # Width of two columns [mm]
RESOLUTION = 200  # Of PNG files [dots per inch]
_SCREEN = 110  # Of figures in a notebook

INK = "#1a1a1a"
GREY = "#6f6f6f"
FAINT = "#d9d9d9"
SHADE = "#f0efe6"
WITHOUT = "#e07b00"
WITH = "#004f86"
PALE = "#eaf1f7"

THICK, LINE, THIN = 1.5, 1.0, 0.5  # Line widths [pt]
DASHED: Any = (0, (4, 2))
SMALL = 7.5  # Small print [pt]

_STYLE: Any = {
    "font.family": ["STIXGeneral", "DejaVu Sans"], "mathtext.fontset": "stix", "font.size": 9.0,
    "axes.titlesize": 9.0, "axes.titlelocation": "left", "axes.labelsize": 9.0,
    "xtick.labelsize": 8.0, "ytick.labelsize": 8.0, "legend.fontsize": 8.0,
    "legend.frameon": False, "legend.handlelength": 1.8, "text.color": INK,
    "axes.edgecolor": INK, "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK,
    "axes.linewidth": 0.6, "axes.spines.top": False, "axes.spines.right": False,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4, "lines.linewidth": LINE, "lines.markersize": 4.0,
    "grid.color": FAINT, "grid.linewidth": 0.4, "axes.axisbelow": True,
    "figure.facecolor": "white", "savefig.facecolor": "white", "svg.hashsalt": "stickslip",
    "svg.fonttype": "path",
}  # fmt: skip
_LOCK = Lock()


@contextmanager
def _boxes() -> Iterator[None]:
    """Draw a box, without a warning, for a character of a name that no font has."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph .* missing from", UserWarning)
        yield


@contextmanager
def house_style() -> Iterator[None]:
    """Draw and save in the house style, which is global: only one thread at a time draws."""
    with _LOCK, mpl.rc_context(), _boxes():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        yield


class PageFigure(Figure):
    """A figure that a notebook shows, whether pyplot is in use or not."""

    def _repr_png_(self) -> bytes:
        content = BytesIO()
        with _boxes():
            self.savefig(content, format="png", dpi=_SCREEN)
        return content.getvalue()


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in mm."""
    size = (width / 25.4, height / 25.4)
    return PageFigure(figsize=size, layout="constrained")


def name_panel(axes: Axes, letter: str, title: str) -> None:
    """Put (a), (b) and what is shown above a panel."""
    axes.set_title(f"({letter}) {title}")


def legend_below(axes: Axes, ncols: int | None = None) -> None:
    """Put the legend of one panel below the whole figure, in one row by default."""
    handles, labels = axes.get_legend_handles_labels()
    figure = axes.get_figure(root=True)
    assert figure is not None  # noqa: S101 - the axes were drawn
    figure.legend(handles, labels, loc="outside lower center", ncols=ncols or len(labels))


def zero_lines(*panels: Axes, vertical: bool = False) -> None:
    """Draw thin lines where the ordinate is 0, and where the abscissa is 0."""
    for axes in panels:
        axes.axhline(0.0, color=FAINT, lw=THIN)
        if vertical:
            axes.axvline(0.0, color=FAINT, lw=THIN)


def log_ticks(
    axis: Axis, low: float, high: float, steps: Sequence[float] = (1.0, 2.0, 5.0)
) -> None:
    """Label a logarithmic axis from one value to another: powers of ten alone where many fit."""
    axis.set_major_locator(LogLocator(subs=(1.0,) if high > 30.0 * low else steps))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
