"""documentation/index.html of an FMU: the README of its model as plain text."""

from __future__ import annotations

import html

from stickslip.models.export.description import Model

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}
pre {{ font: 14px/1.4 monospace; white-space: pre-wrap; }}
</style>
</head>
<body>
<img src="../{icon}" alt="" width="96" height="96">
<pre>{body}</pre>
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
    return _PAGE.format(title=html.escape(model.title), icon=icon, body=html.escape(text))
