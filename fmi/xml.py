"""Untrusted XML: UTF-8, no DTD and so no entities, nothing fetched, bounded in depth."""

from __future__ import annotations

import re
from typing import Any

from lxml import etree

from stickslip.fmi.messages import printable, shown

MAX_BYTES = 2**27
"""Of a document, which takes 25 times as much memory; a million variables have 100 MB."""

_WIDE = (b"\xff\xfe", b"\xfe\xff", b"<\0", b"\0<")
_DECLARED = re.compile(rb"""\s*<\?xml[^>]*?\sencoding\s*=\s*["']([^"'>]*)["']""")
# What may stand before the first element; possessive, so that no text takes more than one pass.
_DOCTYPE = re.compile(rb"(?:\s++|<\?.*?\?>|<!--.*?-->)*+<!DOCTYPE", re.DOTALL)
_UTF8 = {b"utf-8", b"utf8", b"us-ascii", b"ascii"}


class Malformed(ValueError):
    """Text that is not read as XML; the message lacks the file's name."""


def parse_xml(
    data: bytes, name: str | None = None, *, remarks: bool = False, lenient: bool = False
) -> Any:
    """Return the root element. No entity is resolved and nothing is fetched.

    Parameters
    ----------
    name : of the file, to be found in ``docinfo.URL``
    remarks : whether comments and processing instructions stay in
    lenient : whether a DOCTYPE and other encodings are accepted, for a checker that reports them

    Raises
    ------
    Malformed
    """
    if len(data) > MAX_BYTES:
        raise Malformed(f"{len(data)} bytes, expected at most {MAX_BYTES}")
    if not lenient and (fault := _fault(data)):
        raise Malformed(fault)
    parser = etree.XMLParser(
        encoding=None if lenient else "utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        dtd_validation=False,
        huge_tree=False,  # at most 10 MB in an attribute, and some hundred elements deep
        remove_comments=not remarks,
        remove_pis=not remarks,
    )
    try:
        return etree.fromstring(data, parser, base_url=name)
    except (etree.XMLSyntaxError, ValueError, LookupError) as error:
        message = " ".join(str(error).split())
        raise Malformed(f"{printable(message)}; export it again") from error


def _fault(data: bytes) -> str | None:
    if data.startswith(_WIDE):
        return "text in UTF-16, expected UTF-8; save it so"
    data = data.removeprefix(b"\xef\xbb\xbf")
    declared = _DECLARED.match(data)
    if declared and declared[1].lower() not in _UTF8 and not data.isascii():
        encoding = shown(declared[1].decode("latin-1"))
        return f"text in the encoding {encoding}, expected UTF-8; save it so"
    if _DOCTYPE.match(data):
        return "a DOCTYPE, which could define entities; none is read: remove it"
    return None
