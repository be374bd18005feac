"""Untrusted XML: no DTD and so no entities, nothing fetched, bounded in size and depth."""

import codecs
import re
from typing import Any

from stickslip.fmi.messages import printable, shown

MAX_BYTES = 2**27
"""Of a document."""
MAX_ELEMENTS = 500_000
"""Of a document, which are 0.5 GB and 10 s when it is read; the largest of 300 public FMUs, with
100,000 variables, has 400,150."""
_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_DECLARED = re.compile(rb"""\s*<\?xml[^>]*?\sencoding\s*=\s*["']([^"'>]*)["']""")
# What may stand before the first element; possessive, so that no text takes more than one pass.
_DOCTYPE = re.compile(rb"(?:\s++|<\?.*?\?>|<!--.*?-->)*+<!DOCTYPE", re.DOTALL)
_CODECS = {"utf-8", "ascii", "iso8859-1", "iso8859-15", "cp1252"}
"""Encodings in which a byte below 128 is what it is in ASCII."""


class Malformed(ValueError):
    """Text that is not read as XML; the message lacks the file's name."""


def parse_xml(
    data: bytes, name: str | None = None, *, remarks: bool = False, lenient: bool = False
) -> Any:
    """Return the root element. No entity is resolved and nothing is fetched.

    The file's ``name`` is found in ``docinfo.URL``. With ``remarks``, comments and processing
    instructions stay in. A DOCTYPE and all encodings are accepted for a ``lenient`` checker, which
    reports them. Raises Malformed.
    """
    if len(data) > MAX_BYTES:
        raise Malformed(f"{len(data)} bytes, expected at most {MAX_BYTES}")
    if data.count(b"<") - data.count(b"</") > MAX_ELEMENTS:
        raise Malformed(f"more than {MAX_ELEMENTS} elements, which is more than is read")
    from lxml import etree  # late, for those who start quickly

    parser = etree.XMLParser(
        encoding=None if lenient else _encoding(data),
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


def _encoding(data: bytes) -> str:
    """Return the encoding of a text without a DOCTYPE: UTF-8, as it should be, or another one."""
    declared = _DECLARED.match(data)
    encoding = "utf-8"
    if data.startswith(_WIDE):
        encoding = "utf-16"
    elif declared and not data.isascii():
        encoding = declared[1].decode("latin-1")
    try:  # codecs passes over letters that are not ASCII
        found = codecs.lookup(encoding).name if encoding.isascii() else ""
        known = encoding == "utf-16" or found in _CODECS
        text = data.decode("utf-16").encode() if encoding == "utf-16" else data
    except (LookupError, ValueError):
        known = False
    if not known:
        raise Malformed(f"text in the encoding {shown(encoding)}, expected UTF-8; save it so")
    if _DOCTYPE.match(text.removeprefix(codecs.BOM_UTF8)):
        raise Malformed("a DOCTYPE, which could define entities; none is read: remove it")
    return encoding
