"""Sphinx builds the site from the root of the repository, so that links of pages hold there too."""

import shutil
import sys
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


def _refer(*event: Any) -> None:
    """Show the section Source of docstrings as numpydoc's References."""
    lines = event[-1]
    for k, line in enumerate(lines[:-1]):
        if line == "Source" and lines[k + 1] == "------":
            lines[k : k + 2] = ["References", "----------"]


def setup(app: Sphinx) -> None:
    """Connect what this project adds to Sphinx and numpydoc."""
    NumpyDocString.sections["Source"] = []
    app.connect("source-read", _list)
    app.connect("autodoc-process-docstring", _refer, priority=400)


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
templates_path = [str(HERE / "_templates")]  # else it is below the root

smartquotes = False  # two hyphens begin an option
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # notebooks are stored with outputs, which tests compare

toc_object_entries_show_parents = "hide"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "signature"
python_maximum_signature_line_length = 88
numpydoc_show_class_members = False

html_title = "stickslip"
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
