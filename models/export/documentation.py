"""A model's README as the FMU's documentation/index.html."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from itertools import groupby

from stickslip.models.export.description import Model

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 50em; margin: 2em auto; padding: 0 1em; }}
pre {{ background: #f4f4f4; padding: 1em; overflow-x: auto; }}
table {{ border-collapse: collapse; }}
td, th {{ border: 1px solid #ccc; padding: 0.2em 0.6em; text-align: left; }}
</style>
</head>
<body>
<img src="../{icon}" alt="" width="96" height="96">
{body}
<h2>Licence</h2>
<p>MIT: <a href="licenses/license.txt">licenses/license.txt</a>. The functions are those of the
Functional Mock-up Interface, whose headers are under the 2-clause BSD licence.</p>
</body>
</html>
"""


def index(model: Model, icon: str) -> str:
    """Return the page. ``icon`` is its picture's path from the root of the FMU."""
    readme = model.folder / "README.md"
    text = f"# {model.title}\n\n{model.description}\n"
    if readme.exists():
        text = readme.read_text(encoding="utf-8")
    if model.law is not None:
        text += "\n" + (model.law.folder / "README.md").read_text(encoding="utf-8")
    body = "\n".join(_blocks(text))
    return _PAGE.format(title=html.escape(model.title), icon=icon, body=body)


def _blocks(text: str) -> Iterator[str]:
    """Yield HTML for each block of what READMEs here use of Markdown.

    Headings, paragraphs, equations indented by four blanks, tables and lists.
    """
    for kind, group in groupby(text.splitlines(), _kind):
        lines = list(group)
        if kind == "heading":
            for line in lines:
                level = len(line) - len(line.lstrip("#"))
                yield f"<h{level}>{_inline(line[level:].strip())}</h{level}>"
        elif kind == "equation":
            yield "<pre>" + html.escape("\n".join(line[4:] for line in lines)) + "</pre>"
        elif kind == "table":
            yield "<table>" + "".join(_rows(lines)) + "</table>"
        elif kind == "list":
            items = re.split(r"^- ", "\n".join(lines), flags=re.MULTILINE)[1:]
            yield "<ul>" + "".join(f"<li>{_inline(item)}</li>" for item in items) + "</ul>"
        elif kind == "paragraph":
            yield f"<p>{_inline(' '.join(lines))}</p>"


def _kind(line: str) -> str:
    if line.startswith("    "):
        return "equation"
    starts = {"#": "heading", "|": "table", "-": "list", " ": "list", "": "blank"}
    return starts.get(line[:1], "paragraph")


def _rows(lines: list[str]) -> Iterator[str]:
    for k, line in enumerate(lines):
        if k != 1:  # the ruler below the head
            tag = "td" if k else "th"
            cells = (cell.strip() for cell in line.strip("|").split(" | "))
            yield (
                "<tr>"
                + "".join(f"<{tag}>{_inline(c.strip('| '))}</{tag}>" for c in cells)
                + "</tr>"
            )


def _inline(text: str) -> str:
    """Return text with code set off; a link to another model stays as its text."""
    text = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", html.escape(text, quote=False))
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
