r"""HTML from templates: text that is not markup yet is escaped, and symbols in it are set.

A symbol is written as in matplotlib: ``$F_c$``, ``$\sigma_0$``, ``$E_{rms}$``. A template ends in
``.j2`` and is named by its path in the package; a text without that ending is a template itself.
Templates have the functions of ``parts.j2`` and those of ``quantity``.
"""

import math
import re
from collections.abc import Iterator
from html import escape, unescape
from importlib.resources import files
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from jinja2.ext import Extension
from jinja2.lexer import Token, TokenStream
from markupsafe import Markup

from stickslip.fmi.messages import escaped
from stickslip.presentation import quantity

__all__ = ["Html", "fill", "parts", "text"]

_SYMBOL = re.compile(r"\$(?:\\(?P<greek>[a-z]+)|(?P<latin>[A-Za-z]))(?:_\{?(?P<index>\w+)\}?)?\$")
_WRAPPED = re.compile(r"(?<!>)\n(?!<)")  # The end of a line of prose


class Html(Markup):
    """Text that is markup already."""

    __slots__ = ()


def text(content: object) -> Markup:
    """Return a text as markup: escaped and with its symbols, unless it is markup already."""
    return content if isinstance(content, Markup) else Html(_symbols(escaped(str(content))))


def _symbols(content: str) -> str:
    """Return a text with its symbols set: letters in italics, indices below the line."""

    def symbol(found: re.Match[str]) -> str:
        greek, index = found["greek"], found["index"]
        letter = escape(unescape(f"&{greek};")) if greek else found["latin"]
        return f"<i>{letter}</i>" + (f"<sub>{index}</sub>" if index else "")

    return _SYMBOL.sub(symbol, content)


class _Prose(Extension):
    """Sets the symbols of the text of a template, and joins its lines."""

    def filter_stream(self, stream: TokenStream) -> Iterator[Token]:
        for token in stream:
            prose = token.type == "data"
            value = _symbols(_WRAPPED.sub(" ", token.value)) if prose else token.value
            yield Token(token.lineno, token.type, value)


_ENVIRONMENT = Environment(
    loader=FunctionLoader(lambda name: files("stickslip").joinpath(name).read_text("utf-8")),
    extensions=[_Prose],
    autoescape=True,
    undefined=StrictUndefined,
    finalize=text,
    trim_blocks=True,
    lstrip_blocks=True,
)
_ENVIRONMENT.globals.update(vars(quantity), math=math)
_ENVIRONMENT.filters.update(
    symbol=quantity.symbol,
    attribute=lambda content: Html(escaped(content)),
    sentence=lambda content: f"{content[:1].upper()}{content[1:]}.",
)


def fill(template: str, **values: object) -> Html:
    """Return a template with its values; raise jinja2.UndefinedError when a value is missing."""
    named = template.endswith(".j2")
    found = _ENVIRONMENT.get_template(template) if named else _ENVIRONMENT.from_string(template)
    return Html(found.render(values))


parts: Any = _ENVIRONMENT.get_template("presentation/parts.j2").module
"""The functions of ``parts.j2``."""
_ENVIRONMENT.globals.update({name: one for name, one in vars(parts).items() if callable(one)})
