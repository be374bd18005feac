"""Sphinx builds the site from the root of the repository, so that links of pages hold there too."""

import shutil
import sys
from contextlib import suppress
from importlib import metadata
from inspect import signature
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import generate  # noqa: E402 - it lies beside this file
from numpydoc.docscrape import NumpyDocString  # noqa: E402 - after the path
from sphinx.application import Sphinx  # noqa: E402 - after the path

shutil.rmtree(HERE / "_generated", ignore_errors=True)  # pages of names that are gone
generate.write(HERE / "_generated")


def _list(_: Sphinx, page: str, source: list[str]) -> None:
    """Put the pages of a folder below its README, which lists them in a table."""
    if page in ("docs/decisions/README", "docs/measurements/README"):
        source[0] += "\n```{toctree}\n:hidden:\n:glob:\n\n[0-9a-z]*\n```\n"


def _adapt(*event: Any) -> None:
    """Show the section Source as numpydoc's References, and what a parameter is in one paragraph.

    numpydoc would take the first line of ``name : what it is`` for a type.
    """
    lines, section, adapted = event[-1], "", []
    for k, line in enumerate(lines):
        if k + 1 < len(lines) and set(lines[k + 1]) == {"-"}:
            section = line
            line = line.replace("Source", "References")
        elif section == "Source":
            line, section = "----------", ""
        name, colon, what = line.partition(" : ")
        if section in ("Parameters", "Attributes") and colon and not line.startswith(" "):
            adapted += [name, f"    {what}"]
        else:
            adapted.append(line)
    lines[:] = adapted


def _name_defaults(_: Sphinx, function: Any, *__: Any) -> None:
    """Show a default value that has no literal by its class."""
    with suppress(AttributeError, TypeError, ValueError):
        own = signature(function)
        parameters = [
            one.replace(default=Named(one.default)) if " at 0x" in repr(one.default) else one
            for one in own.parameters.values()
        ]
        function.__signature__ = own.replace(parameters=parameters)


class Named:
    """A value that shows its class."""

    def __init__(self, value: object) -> None:
        self._name = type(value).__name__

    def __repr__(self) -> str:
        return f"{self._name}(...)"


def setup(app: Sphinx) -> None:
    """Connect what this project adds to Sphinx and numpydoc."""
    NumpyDocString.sections["Source"] = []
    app.connect("source-read", _list)
    app.connect("autodoc-before-process-signature", _name_defaults)
    app.connect("autodoc-process-docstring", _adapt, priority=400)


project = "stickslip"
author = "The stickslip authors"
copyright = "2026, the stickslip authors"  # noqa: A001 - the name that Sphinx reads
root_doc = "docs/index"
include_patterns = [
    "docs/**",
    "notebooks/*.ipynb",
    "models/**/README.md",
    "results/coupling/coupling.md",
    *("ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"),
]
exclude_patterns = [".*", "**/.*", "docs/_build", "docs/_templates", "docs/_extra"]
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "numpydoc",
    "sphinx_design",
]
suppress_warnings = ["myst.header"]  # a README of a model begins where its table does
autosummary_context = {"used": generate.uses()}
templates_path = [str(HERE / "_templates")]  # else it is below the root

smartquotes = False  # two hyphens begin an option
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # notebooks are stored with outputs, which tests compare

toc_object_entries_show_parents = "hide"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_maximum_signature_line_length = 88
numpydoc_show_class_members = False

release = metadata.version("stickslip")
html_title = f"stickslip {release}"
html_theme = "pydata_sphinx_theme"
html_static_path = ["_static", "_generated/static"]
html_css_files = ["site.css"]
html_extra_path = ["_extra"]  # the first page is docs/index.html: this leads there
html_show_sourcelink = False
html_copy_source = False
html_context = {"default_mode": "auto"}
html_theme_options = {
    "navbar_align": "left",
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
mathjax_path = "mathjax.js"
