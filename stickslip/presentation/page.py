"""The page of a report: sections of text, figures and tables in one HTML file.

    write_page(folder, "Friction of a drive", [Section("The fit", paragraph("..."), figure)])

The page holds its figures and its style, and needs no network. Each figure is also written as PNG
and SVG, and opens to be zoomed where it has long lines. The same sections give the same bytes.
"""

from __future__ import annotations

import base64
import io
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from string import Template

from matplotlib.figure import Figure

from stickslip.fmi.files import atomic_write
from stickslip.fmi.messages import escaped
from stickslip.presentation.interactive import Panel, panels, scripts
from stickslip.presentation.markup import Html, element, join, paragraph, table, text
from stickslip.presentation.style import COLUMN, RESOLUTION, house_style
from stickslip.versions import installed_versions

PACKAGES = (
    "stickslip",
    "numpy",
    "scipy",
    "control",
    "pandas",
    "fmpy",
    "ziglang",
    "matplotlib",
    "bokeh",
)
_PAGE = Template("""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>$title</title>
<style>
$style</style>
</head>
<body>
<main>
<h1>$title</h1>
$sections
</main>
$scripts</body>
</html>
""")


@dataclass(frozen=True)
class Illustration:
    """A figure of a section.

    Attributes
    ----------
    name : of its files, without ``.png`` and ``.svg``
    draw : draws it
    alternative : text for readers who do not see the figure
    """

    name: str
    draw: Callable[[], Figure]
    alternative: str
    caption: str


class Section:
    """A part of a page.

    Parameters
    ----------
    title : its heading; empty for the head of the page
    content : markup and illustrations in their order; a list of illustrations is one row
    """

    def __init__(self, title: str, *content: Html | Illustration | list[Illustration]) -> None:
        self.title, self.content = title, content

    def illustrations(self) -> list[Illustration]:
        """Return its illustrations."""
        parts = [part if isinstance(part, list) else [part] for part in self.content]
        return [one for part in parts for one in part if isinstance(one, Illustration)]

    def markup(self, pictures: Mapping[str, Picture]) -> Html:
        """Return the section with its illustrations as drawn."""
        parts = [_markup(part, pictures) for part in self.content]
        if not self.title:
            return join(parts, "\n")
        return element("section", join([element("h2", self.title), *parts], "\n"))


def render(title: str, sections: Iterable[Section], pictures: Mapping[str, Picture]) -> str:
    """Return a page as HTML.

    Parameters
    ----------
    pictures : the illustrations by name, in the order of their numbers
    """
    opened = {name: picture.panels for name, picture in pictures.items() if picture.panels}
    return _PAGE.substitute(
        title=text(title),
        style=files(__package__).joinpath("page.css").read_text(encoding="utf-8"),
        sections=join((section.markup(pictures) for section in sections), "\n"),
        scripts=f"{scripts(opened)}\n" if opened else "",
    )


def write_page(
    folder: Path, title: str, sections: Sequence[Section], file: str = "report.html"
) -> list[Path]:
    """Write each illustration as PNG and SVG, and the page.

    Parameters
    ----------
    folder : is made if it is absent; each file of the same name is replaced atomically
    file : name of the page

    Returns
    -------
    the files written, the page last

    Raises
    ------
    OSError
        When the folder cannot be written.
    """
    shown = [one for section in sections for one in section.illustrations()]
    pictures = {one.name: Picture.of(one.draw) for one in shown}
    written = []
    for name, picture in pictures.items():
        written.append(atomic_write(folder / f"{name}.png", picture.png))
        written.append(atomic_write(folder / f"{name}.svg", picture.svg))
    page = render(title, sections, pictures)
    return [*written, atomic_write(folder / file, page)]


def file_list(items: Mapping[str, str]) -> Html:
    """Return the files in the folder of the page, each with a description."""
    rows = (element("li", element("code", name), ": ", what) for name, what in items.items())
    listed = element("ul", join(rows, "\n"))
    return join([paragraph("The folder of this page also contains:"), listed])


def commands(*lines: str) -> Html:
    """Return commands of a shell, a line each."""
    return element("pre", element("code", "\n".join(lines)))


def made_with() -> Html:
    """Return a table of versions."""
    versions = installed_versions(PACKAGES)
    rows = [("Python", platform.python_version()), *versions.items()]
    return table(("Package", "Version"), rows, "Versions", (0, 1))


def _markup(
    part: Html | Illustration | list[Illustration], pictures: Mapping[str, Picture]
) -> Html:
    if isinstance(part, list):
        return element("div", join((_markup(one, pictures) for one in part), "\n"), class_="row")
    if isinstance(part, Illustration):
        return _figure(part, pictures[part.name], [*pictures].index(part.name) + 1)
    return part


def _figure(shown: Illustration, picture: Picture, number: int) -> Html:
    """Return a picture on its card, with its number on the page and a caption."""
    alternative = shown.alternative
    image = Html(f'<img src="{picture.embedded()}" alt="{escaped(alternative)}">')
    kind = "column" if picture.width <= COLUMN else "page"
    card = element(
        "div", image, class_="scroll", tabindex="0", role="region", aria_label=alternative
    )
    plot = {"data_plot": shown.name} if picture.panels else {}
    return element(
        "figure",
        card,
        element("figcaption", f"Figure {number}. ", shown.caption),
        class_=kind,
        **plot,
    )


MILLIMETRES = 25.4
"""In an inch, matplotlib's unit."""


def picture_files(names: Iterable[str]) -> list[str]:
    """Return the names of the files of pictures."""
    return [f"{name}.{kind}" for name in names for kind in ("png", "svg")]


@dataclass(frozen=True)
class Picture:
    """One figure.

    Attributes
    ----------
    png, svg : contents of the files, without dates and so the same each time
    width : [mm]
    panels : what a page draws when the figure is opened
    """

    png: bytes
    svg: bytes
    width: float
    panels: list[Panel] = field(default_factory=list)

    @classmethod
    def of(cls, draw: Callable[..., Figure], *subjects: object) -> Picture:
        """Draw a figure of its subjects in the house style."""
        with house_style():
            figure = draw(*subjects)
            _settle(figure)
            png, svg = io.BytesIO(), io.BytesIO()
            figure.savefig(png, format="png", dpi=RESOLUTION, metadata={"Software": None})
            figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
        width = float(figure.get_figwidth()) * MILLIMETRES
        return cls(png.getvalue(), svg.getvalue(), width, panels(figure))

    def embedded(self) -> str:
        """Return the picture as a data URI, which needs no further file.

        As an image of its own its ids and styles do not meet those of the page.
        """
        return "data:image/svg+xml;base64," + base64.b64encode(self.svg).decode("ascii")


def _settle(figure: Figure) -> None:
    """Place the axes for good, to six digits: the layout's solver varies in the last ones."""
    if figure.get_layout_engine() is None:
        return
    figure.draw_without_rendering()
    figure.set_layout_engine(None)
    for axes in figure.axes:
        left, bottom, width, height = (round(side, 6) for side in axes.get_position().bounds)
        axes.set_position((left, bottom, width, height))
