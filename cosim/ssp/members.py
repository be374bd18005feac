"""The files in a package by name, and the package made of them."""

from __future__ import annotations

import io
import re
import zipfile

_TIMESTAMP = (1980, 1, 1, 0, 0, 0)  # the same system gives the same bytes

Members = dict[str, bytes]


def file_name(i: int, name: str) -> str:
    """Return a file name for a component."""
    return re.sub(r"[^\w-]", "_", f"{i}_{name}", flags=re.ASCII)


def free_name(stem: str, suffix: str, members: Members) -> str:
    """Return a member name that is not taken."""
    name, n = stem + suffix, 1
    while name in members:
        n += 1
        name = f"{stem}_{n}{suffix}"
    return name


def zipped(members: Members) -> bytes:
    """Return the package."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in sorted(members.items()):
            member = zipfile.ZipInfo(name, _TIMESTAMP)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.create_system = 3
            member.external_attr = 0o644 << 16
            archive.writestr(member, content)
    return buffer.getvalue()
