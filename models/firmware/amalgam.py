"""Several C files as one: what a model needs, callees first, all functions static.

Reads the C of this project, in which every definition begins in the first column, ends before the
next blank line outside braces, and has its comment above it or above its prototype.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_PROTOTYPE = re.compile(r"^[\w ]+?[ *](\w+)\([^{}]*\);$", re.DOTALL)
_DEFINED = {  # -> what stands before it here
    re.compile(r"^[\w ]+?[ *](\w+)\([^{};]*\) \{", re.DOTALL): "static ",
    re.compile(r"^typedef .*\} (\w+);$", re.DOTALL): "",
    re.compile(r"^#define (\w+)\("): "",
    re.compile(r"^static const double (\w+) = "): "static ",
    re.compile(r"^enum \{ (\w+) = "): "",
}


def pieces(texts: Iterable[str]) -> dict[str, str]:
    """Return name -> definition with its comment: functions, types, constants and macros."""
    split = [_split(block) for text in texts for block in _blocks(text)]
    comments = {match[1]: comment for comment, code in split if (match := _PROTOTYPE.match(code))}
    found = {}
    for comment, code in split:
        for pattern, before in _DEFINED.items():
            if match := pattern.match(code):
                name, own = match[1], code.removeprefix("static ").removeprefix("inline ")
                found[name] = (comment or comments.get(name, "")) + before + own
    return found


def needed(found: dict[str, str], roots: Iterable[str]) -> list[str]:
    """Return the names that the roots need, the roots included, each after what it needs."""
    order: list[str] = []

    def visit(name: str) -> None:
        for word in re.findall(r"\w+", without_comments(found[name])):
            if word in found and word != name and word not in order:
                visit(word)
        order.append(name)

    for root in roots:
        if root not in order:
            visit(root)
    return order


def without_comments(text: str) -> str:
    """Return C without its comments."""
    return _COMMENT.sub("", text)


def _blocks(text: str) -> Iterator[str]:
    """Yield what stands between blank lines outside braces; constants one by one."""
    block: list[str] = []
    for line in [*text.splitlines(), ""]:
        joined = "\n".join(block)
        if line.startswith("static const ") and line.count("{") == 0:
            yield line
        elif line or joined.count("{") > joined.count("}"):
            block.append(line)
        elif block:
            yield joined
            block = []


def _split(block: str) -> tuple[str, str]:
    """Return the comment above a block, and what follows it."""
    code = without_comments(block).lstrip()
    begin = block.index(code.splitlines()[0]) if code else len(block)
    return block[:begin], block[begin:]
