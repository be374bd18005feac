"""One HTML file that holds its figures and its style, and needs no script and no network."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.resources import files
from string import Template

from stickslip.report.markup import text

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


def sheet(title: str, sections: Iterable[str]) -> str:
    """Return a page of sections, which are markup, in the house style."""
    return _PAGE.substitute(
        title=text(title),
        style=files(__package__).joinpath("page.css").read_text(encoding="utf-8"),
        sections="\n".join(sections),
    )
