"""The page: one file that holds its figures and its style, and needs no script and no network."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from string import Template

from stickslip.report import (
    section_design,
    section_identification,
    section_learning,
    section_result,
    section_use,
    section_validation,
)
from stickslip.report.picture import Picture
from stickslip.reproduction import Reproduction

TITLE = "Friction compensator of a linear motor, learned"

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
</body>
</html>
""")


def page(reproduction: Reproduction, pictures: Mapping[str, Picture]) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    reproduction : every number comes from here
    pictures : by the names of ``FIGURES``
    """
    sections = (
        section_result,
        section_design,
        section_identification,
        section_learning,
        section_validation,
        section_use,
    )
    return _PAGE.substitute(
        title=TITLE,
        style=files(__package__).joinpath("page.css").read_text(encoding="utf-8"),
        sections="\n".join(section.write(reproduction, pictures) for section in sections),
    )
