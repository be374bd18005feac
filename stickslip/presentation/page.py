"""The page of a report: sections of text, figures and tables in one HTML file.

    write_page(folder, "Friction of a drive", [Section("The fit", "<p>...</p>")])

The page holds its figures and its style, and needs no network. Each figure is also written as PNG
and SVG, and opens to be zoomed where it has long lines. The same sections give the same bytes.
"""

import base64
import io
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from matplotlib.figure import Figure

from stickslip.fmi.files import atomic_write
from stickslip.presentation.interactive import Panel, panels, scripts
from stickslip.presentation.markup import Html, fill, parts
from stickslip.presentation.style import COLUMN, RESOLUTION, house_style
from stickslip.versions import installed_versions

PACKAGES = (
    *("stickslip", "numpy", "scipy", "control", "pandas"),
    *("fmpy", "ziglang", "matplotlib", "bokeh"),
)


class Section:
    """A part of a page.

    Its content calls ``figure(name, alternative)``, with the caption as its content and a text for
    readers who do not see the figure.
    """

    def __init__(
        self,
        title: str,  # its heading; empty for the head of the page
        content: str,  # the name of a template, or its text
        # what draws each figure, in the order of their numbers
        figures: Mapping[str, Callable[[], Figure]] | None = None,
        **values: object,  # of the template
    ) -> None:
        self.title, self.content = title, content
        self.figures, self.values = figures or {}, values

    def markup(self, pictures: "Mapping[str, Picture]") -> Html:
        """Return the section with its figures as drawn."""

        def figure(name: str, alternative: str, caller: Callable[[], Html]) -> Html:
            picture, number = pictures[name], [*pictures].index(name) + 1
            kind = "column" if picture.width <= COLUMN else "page"
            return Html(
                parts.figure(name, alternative, caller(), picture=picture, kind=kind, number=number)
            )

        content = fill(self.content, figure=figure, made_with=made_with, **self.values)
        return Html(parts.section(self.title, content)) if self.title else content


def render(title: str, sections: Iterable[Section], pictures: "Mapping[str, Picture]") -> str:
    """Return a page as HTML; the figures are in the order of their numbers."""
    opened = {name: picture.panels for name, picture in pictures.items() if picture.panels}
    return fill(
        "presentation/page.j2",
        title=title,
        style=Html(files(__package__).joinpath("page.css").read_text(encoding="utf-8")),
        sections=[section.markup(pictures) for section in sections],
        scripts=scripts(opened),
    )


def write_page(
    folder: Path, title: str, sections: Sequence[Section], file: str = "report.html"
) -> list[Path]:
    """Write each figure as PNG and SVG, and the page; return the files, the page last."""
    drawn = {name: draw for section in sections for name, draw in section.figures.items()}
    pictures = {name: Picture.of(draw) for name, draw in drawn.items()}
    written = []
    for name, picture in pictures.items():
        written.append(atomic_write(folder / f"{name}.png", picture.png))
        written.append(atomic_write(folder / f"{name}.svg", picture.svg))
    page = render(title, sections, pictures)
    return [*written, atomic_write(folder / file, page)]


def made_with() -> Html:
    """Return a table of versions."""
    versions = installed_versions(PACKAGES)
    rows = [("Python", platform.python_version()), *versions.items()]
    return Html(parts.table(("Package", "Version"), rows, "Versions", (0, 1)))


MADE_WITH = Section("Made with", "{{ made_with() }}")
MILLIMETRES = 25.4  # In an inch, matplotlib's unit


def picture_files(names: Iterable[str]) -> list[str]:
    """Return the names of the files of pictures."""
    return [f"{name}.{kind}" for name in names for kind in ("png", "svg")]


@dataclass(frozen=True)
class Picture:
    """One figure."""

    # contents of the files, without dates and so the same each time
    png: bytes
    svg: bytes
    width: float  # [mm]
    panels: list[Panel] = field(default_factory=list)  # what a page draws when the figure is opened

    @classmethod
    def of(cls, draw: Callable[[], Figure]) -> "Picture":
        """Draw a figure in the house style."""
        with house_style():
            figure = draw()
            _settle(figure)
            png, svg = io.BytesIO(), io.BytesIO()
            figure.savefig(png, format="png", dpi=RESOLUTION, metadata={"Software": None})
            figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
        width = float(figure.get_figwidth()) * MILLIMETRES
        return cls(png.getvalue(), svg.getvalue(), width, panels(figure))

    def embedded(self) -> str:
        """Return the picture as a data URI, so that its ids and styles do not meet the page's."""
        return "data:image/svg+xml;base64," + base64.b64encode(self.svg).decode("ascii")


def _settle(figure: Figure) -> None:
    """Place the axes for good, to six digits: the layout's solver varies in the last ones."""
    engine = figure.get_layout_engine()
    if engine is None:
        return
    engine.execute(figure)
    figure.set_layout_engine(None)
    for axes in figure.axes:
        left, bottom, width, height = (round(side, 6) for side in axes.get_position().bounds)
        axes.set_position((left, bottom, width, height))
