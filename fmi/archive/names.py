"""Names of members: which can become files below a folder."""

from __future__ import annotations

import os
import re
import sys
import unicodedata
from collections.abc import Iterable
from pathlib import PurePosixPath

from stickslip.fmi.messages import shown

MAX_DEPTH = 64
MAX_LENGTH = 1000  # bytes of a path
_MAX_PART = 255  # bytes, of every usual file system

_FOLDS = sys.platform in ("win32", "darwin")
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
_LEAVES = re.compile(r"^/|^[A-Za-z]:|(^|/)\.\.(/|$)")
# Device names of Windows, which they are with any extension, too.
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9\u00b9\u00b2\u00b3])", re.I)


class Refused(Exception):
    """An archive that is not unpacked; the message lacks its path, which the caller knows."""


def is_device(name: str) -> bool:
    """Tell whether Windows takes a file of this name for a device."""
    return _DEVICE.fullmatch(name.partition(".")[0].rstrip(" ")) is not None


def place(name: str) -> PurePosixPath:
    """Return where a member goes, relative to the folder it is unpacked to."""
    if fault := _fault(name):
        raise Refused(f"member {shown(name)} {fault}")
    return PurePosixPath(name)


def _fault(name: str) -> str | None:
    if _CONTROL.search(name):
        return "has control characters in its name; pack the archive again without them"
    if "\\" in name:
        return "has a backslash in its name, where the standard wants '/'; pack the archive again"
    if _LEAVES.search(name):
        return "would leave the folder it is unpacked to; only relative paths are unpacked"
    parts = name.removesuffix("/").split("/")
    if not all(parts):
        return "has an empty part in its path; pack the archive again"
    if parts[-1] == "." and not name.endswith("/"):
        return "names a folder, and is a file; pack the archive again"
    if len(parts) > MAX_DEPTH:
        return f"lies {len(parts)} folders deep, expected at most {MAX_DEPTH}"
    length = len(name.encode())
    if length > MAX_LENGTH or any(len(part.encode()) > _MAX_PART for part in parts):
        return f"has a path of {length} bytes, expected at most {MAX_LENGTH}, {_MAX_PART} in a part"
    if os.name == "nt":
        if ":" in name:
            return "has a colon in its name, which names a drive or a stream on Windows; rename it"
        if any(p.endswith((".", " ")) and p != "." for p in parts):
            return "has a name with a dot or blank at its end, which Windows drops; rename it"
        if any(map(is_device, parts)):
            return "has the name of a device of Windows; rename it"
    return None


def check_distinct(places: Iterable[tuple[PurePosixPath, bool]]) -> None:
    """Check that no two members (path, whether it is a folder) need the same place.

    Upper and lower case, and accents written as one letter or two, count as the same on systems
    where they are.
    """
    files: dict[str, PurePosixPath] = {}
    folders: dict[str, PurePosixPath] = {}
    for path, is_folder in places:
        key = _key(path)
        if not is_folder:
            if key in files:
                raise Refused(f"member {shown(str(path))} occurs twice; keep one")
            files[key] = path
        for folder in (path, *path.parents) if is_folder else path.parents:
            folders.setdefault(_key(folder), folder)
    if both := files.keys() & folders.keys():
        name = shown(str(files[min(both)]))
        raise Refused(f"member {name} is a file, and a folder of other members; rename one")


def _key(path: PurePosixPath) -> str:
    name = str(path)
    return unicodedata.normalize("NFC", name).casefold() if _FOLDS else name
