"""Files: atomic writes, locks, and limited reads of untrusted input."""

from stickslip.fmi.files.atomic import atomic_write, require_regular_file, sync_folder
from stickslip.fmi.files.lock import is_at, lock
from stickslip.fmi.files.reading import (
    MOST_TEXT,
    digest,
    open_regular_file,
    parse_json,
    parse_toml,
    read_limited,
)

__all__ = [
    "MOST_TEXT",
    "atomic_write",
    "digest",
    "is_at",
    "lock",
    "open_regular_file",
    "parse_json",
    "parse_toml",
    "read_limited",
    "require_regular_file",
    "sync_folder",
]
