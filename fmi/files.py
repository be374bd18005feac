"""Files: atomic writes, locks, and limited reads of untrusted input."""

import errno
import hashlib
import json
import os
import re
import stat
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path
from typing import IO, Any, BinaryIO


def lock(file: IO[Any]) -> bool:
    """Lock an open file until it is closed; False if another has it, OSError without locks."""
    if sys.platform == "win32":
        import msvcrt

        position = file.tell()
        file.seek(2**30)  # a lock on bytes that exist would keep others from reading them
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        finally:
            file.seek(position)
        return True
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def is_at(file: IO[Any], path: Path) -> bool:
    """Return whether an open file still is the one of that name."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.lstat())
    except FileNotFoundError:
        return False


_TEMPORARY = re.compile(r"\.stickslip-[0-9a-f]{32}")


def atomic_write(path: Path, content: bytes | str | Iterable[bytes | str]) -> Path:
    """Write a file so that a reader sees the old one or the new one, never a part of it.

    Text, whole or in parts, is written as UTF-8. The folder is made if it is absent. What killed
    processes left in it half-written is deleted. OSError when there is a link or no plain file of
    that name, the folder cannot be written or the disk is full; ``path`` is then as it was. The
    error names ``path``.
    """
    parts = [content] if isinstance(content, bytes | str) else content
    with atomic_file(path) as file:
        file.writelines(one.encode() if isinstance(one, str) else one for one in parts)
    return path


@contextmanager
def atomic_file(path: Path) -> Iterator[BinaryIO]:
    """Open a file that gets its name when the block has ended without an error, see atomic_write.

    Errors of the block that name another file stay as they are.
    """
    require_regular_file(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    _sweep(path.parent)
    try:
        with _beside(path.parent) as (file, temporary):
            yield file
            file.flush()
            os.fsync(file.fileno())
            if sys.platform == "win32":
                file.close()  # there an open file cannot be renamed
            temporary.replace(path)
        sync_folder(path.parent)
    except OSError as fault:
        name = Path(fault.filename or path)
        if name in {path, path.parent} or _TEMPORARY.fullmatch(name.name):
            raise OSError(fault.errno, fault.strerror, str(path)) from fault
        raise


def require_regular_file(path: Path) -> None:
    """Raise OSError where there is a link, a folder or a device of that name."""
    try:
        mode = path.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return
    if stat.S_ISLNK(mode):
        raise OSError(errno.ELOOP, "is a symbolic link, expected a plain file", str(path))
    if not stat.S_ISREG(mode):
        said = f"is a {'folder' if stat.S_ISDIR(mode) else 'device'}, expected a plain file"
        raise OSError(errno.EISDIR, said, str(path))


def sync_folder(folder: Path) -> None:
    """Have the names in a folder on the disk, where the system knows how."""
    if sys.platform == "win32":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def _beside(folder: Path) -> Iterator[tuple[BinaryIO, Path]]:
    """Open a new file, locked as long as it is open; it is gone at the end unless renamed."""
    while True:
        temporary = folder / f".stickslip-{os.urandom(16).hex()}"
        with temporary.open("xb") as file:
            try:
                with suppress(OSError):  # without locks nobody will sweep it either
                    lock(file)
                if is_at(file, temporary):  # else it was swept before it was locked
                    yield file, temporary
                    return
            finally:
                if sys.platform == "win32":
                    file.close()
                temporary.unlink(missing_ok=True)


def _sweep(folder: Path) -> None:
    """Delete temporary files whose processes are gone: nobody has them locked."""
    with os.scandir(folder) as entries:  # a cache has thousands
        temporary = [Path(entry) for entry in entries if _TEMPORARY.fullmatch(entry.name)]
    for path in temporary:
        with suppress(OSError):
            if stat.S_ISREG(path.lstat().st_mode):
                with path.open("rb") as file:
                    swept = lock(file)
                    if swept and sys.platform != "win32":
                        path.unlink()
                if swept:
                    path.unlink(missing_ok=True)


DEEPEST = 32
"""Lists and tables within each other, and names joined by dots."""
MOST_TEXT = 1 << 25
"""Bytes of a document."""
_STRINGS = re.compile(
    r'"""(?:\\.|[^\\])*?"""|\'\'\'.*?\'\'\'|"(?:\\.|[^"\\\n])*+"|\'[^\'\n]*+\'|#[^\n]*+', re.DOTALL
)
_BITS = 1023
_BETWEEN_KEYS = re.compile(r"[,{}\[\]=\n]")


def read_limited(path: str | os.PathLike[str], most: int) -> bytes:
    """Return what a file holds; OSError where it has more bytes than ``most``."""
    with open_regular_file(path) as file:
        stated = os.fstat(file.fileno()).st_size
        data = file.read(most + 1) if stated <= most else b""
        size = max(stated, len(data))  # of some files the system says 0
        if size > most:
            said = f"{size} bytes, at most {most} are read; take a part of it"
            raise _refused(errno.EFBIG, said, path)
    return data


def digest(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of what a file holds, in hexadecimal."""
    with open_regular_file(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def open_regular_file(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a regular file; OSError where it is none: a pipe or a device may never end."""
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        number = os.open(path, flags)
    except ValueError:  # NUL, or half a character
        raise _refused(errno.EINVAL, "no name that a file can have", path) from None
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise _refused(errno.EINVAL, "no regular file; write it to one first", path)
    return os.fdopen(number, "rb")


def parse_json(data: bytes) -> Any:
    """Return JSON in UTF-8; ValueError for other text, repeated keys, NaN and deep nesting."""
    text = _text(data)
    try:
        content = json.loads(text, object_pairs_hook=_distinct, parse_constant=_no_number)
    except RecursionError:
        raise _too_deep() from None
    _check_extent(content)
    return content


def parse_toml(data: bytes) -> dict[str, Any]:
    """Return the content of TOML; ValueError where it is none, or is nested too deeply."""
    text = _text(data)
    import tomllib  # late, for those who start quickly

    # tomllib takes minutes for a name of 100,000 parts
    if any(part.count(".") > DEEPEST for part in _BETWEEN_KEYS.split(_STRINGS.sub("", text))):
        raise _too_deep()
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise _too_deep() from None
    _check_extent(content)
    return content


def _text(data: bytes) -> str:
    """Return text in UTF-8; raise ValueError with the line of a byte that is not."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = data.count(b"\n", 0, fault.start) + 1
        raise ValueError(f"line {line}: byte 0x{data[fault.start]:02x} is no UTF-8") from None


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) < len(pairs):
        twice = Counter(name for name, _ in pairs).most_common(1)[0][0]
        raise ValueError(f"{twice[:80]!r} is there twice")
    return content


def _no_number(name: str) -> Any:
    raise ValueError(f"{name} is no number of JSON")


def _check_extent(content: object) -> None:
    """Check that content is not nested too deeply and that its integers can become floats."""
    level = [content]
    for _ in range(DEEPEST + 1):
        if any(isinstance(x, int) and x.bit_length() >= _BITS for x in level):
            raise ValueError("holds a number beyond 1e308")
        lists = [x for x in level if isinstance(x, list)]
        lists += [list(x.values()) for x in level if isinstance(x, dict)]
        level = [inner for part in lists for inner in part]
        if not level:
            return
    raise _too_deep()


def _too_deep() -> ValueError:
    return ValueError(f"nested too deeply; at most {DEEPEST} levels are read")


def _refused(number: int, said: str, path: str | os.PathLike[str]) -> OSError:
    return OSError(number, said, os.fspath(path))
