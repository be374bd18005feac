"""C sources in, a shared library out: compiled, or taken from ``compiled.zip`` of a wheel.

A member of the archive is called RECIPE/FILE; its comment is the version of the compiler.
"""

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from itertools import chain
from pathlib import Path

from stickslip.fmi.binary import read_library
from stickslip.fmi.files import atomic_write, lock
from stickslip.fmi.messages import installing
from stickslip.fmi.process.child import child_process
from stickslip.fmi.process.interruption import check_interruption, temporary_folder
from stickslip.fmi.toolchain import platforms
from stickslip.fmi.toolchain.keeping import kept

ARCHIVE = Path(__file__).with_name("compiled.zip")


@cache
def _content(archive: Path) -> tuple[str, frozenset[str]]:
    """Return the version of the compiler, and the names of the members."""
    if not archive.exists():
        return "", frozenset()
    with zipfile.ZipFile(archive) as opened:
        return opened.comment.decode(), frozenset(opened.namelist())


# No fused multiply-add and a named target: the same bits on every processor.
# -O2 also keeps the compiler from linking its debug runtime (4 MB) into each library.
_FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden")
_LINKED = ("-shared", "-s")
# macOS exports these from every library.
_OF_THE_LINKER = {"__dso_handle", "_mh_dylib_header"}
_STANDALONE = ("-nostdlib", "-lcompiler_rt", "-lkernel32")
# What ziglang prints where it cannot write.
_FULL = ("NoSpaceLeft", "DiskQuota")
_CLOSED = ("ReadOnlyFileSystem", "AccessDenied", "PermissionDenied")
# Of the compiler's own functions, which take 4 s to compile once, 64-bit systems need none.
_NO_RUNTIME = "-rtlib=none"
_OBJECT = "common.o"
_LOOK = 0.1  # s between two looks for an interruption, or at a lock
_WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")


def shared_library(
    name: str,
    files: Mapping[str, str],
    *,
    common: Mapping[str, str] | None = None,
    platform: platforms.Platform | None = None,
    flags: Sequence[str] = (),
    standalone: bool = False,
    exports: Collection[str] | None = None,
    loads: bool = False,
) -> Path:
    """Compile the ``.c`` files among ``files`` into one shared library and return its path.

    It lies in the cache under a hash of all that went in; its own hash lies beside it, and what is
    damaged is built again. What came with the package is taken from its archive. Raises
    CompilerMissing, CompilationFailed, CacheUnusable, WrongExports.

    Parameters
    ----------
    files : relative path -> text of every source and header. Headers in ``system/`` are found
        with ``<...>`` and raise no warnings; the others are found from the root of the tree.
    common : such files of which other libraries have the same, compiled once for all of them: one
        source and its headers
    flags : further compiler flags. Those in ``$STICKSLIP_CFLAGS`` come last, such as a sanitizer's;
        ``$STICKSLIP_CC`` names a system compiler to take for this machine, which may know more of
        them than ziglang does
    standalone : on Windows, link with the system alone instead of a C runtime, which may be absent
        there and takes a minute to compile; the sources may then call nothing of it but ``mem...``
    exports : the names that the library must export, these and no others; not looked at if None
    loads : whether it loads other libraries, so that ``compiled_here`` does not vouch for it
    """
    target = platform or platforms.host_platform()
    bare = standalone and target.suffix == ".dll"
    common = dict(common or {})
    if bare:
        files = {**files, **_standalone()}
        headers = {path: text for path, text in _standalone().items() if path.endswith(".h")}
        common |= headers if common else {}
    call = [sys.executable, "-m", "ziglang", "cc", "-target", target.target]
    call += [] if target.suffix == ".dll" else [_NO_RUNTIME]
    if (own := os.environ.get("STICKSLIP_CC")) and target == platforms.host_platform():
        call = ["env", own, "-Wno-unknown-pragmas"]
    call += [*_FLAGS, *_WARNINGS, *flags, "-I.", "-isystem", "system"]
    call += os.environ.get("STICKSLIP_CFLAGS", "").split()
    command = [*call, *_LINKED, *(_STANDALONE if bare else ())]
    command += sorted(path for path in files if path.endswith(".c"))
    if target.suffix == ".dylib":
        command.append(f"-Wl,-install_name,@rpath/{name}.dylib")
    recipe = _digest([target.target, name, *command[1:]], [files, common])
    file = name + target.suffix
    member = f"{recipe}/{file}"
    version, members = _content(ARCHIVE)
    compiler = version if (is_shipped := member in members) else compiler_version()
    library = platforms.cache_directory() / "libraries" / f"{recipe}-{compiler}" / file
    if not _is_whole(library):
        try:
            with _alone(library.parent):
                if not _is_whole(library):  # another process may just have compiled it
                    if is_shipped:
                        with zipfile.ZipFile(ARCHIVE) as opened:
                            linked = opened.read(member)
                    else:
                        objects = _object(call, common)
                        linked = _compile([*command, *objects], {**files, **objects}, file)
                    if exports is not None:
                        _check_exports(linked, exports, library.name)
                    atomic_write(library, linked)
                    atomic_write(_hash_file(library), hashlib.sha256(linked).hexdigest())
        except OSError as fault:
            place = Path(fault.filename or library)
            raise _unusable(place, fault.strerror or str(fault)) from fault
    if not loads:
        vouch(_hash_file(library).read_text())
    return library


def compiled_here(library: Path) -> bool:
    """Return whether a library has the bytes of one that was compiled into this cache."""
    try:
        return _noted(hashlib.sha256(library.read_bytes()).hexdigest()).exists()
    except OSError:
        return False


def vouch(digest: str) -> None:
    """Let ``compiled_here`` know the SHA-256 of a library that was made from one of this cache."""
    with suppress(OSError):  # a cache that is read only
        if not _noted(digest).exists():
            _noted(digest).parent.mkdir(exist_ok=True)
            _noted(digest).touch()


def _noted(digest: str) -> Path:
    return platforms.cache_directory() / "compiled" / digest


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Wait until no other process or thread compiles into a folder, where locks work."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "lock"
    with path.open("ab") as file:
        with suppress(OSError):  # the file system has no locks
            while not lock(file):
                check_interruption()
                time.sleep(_LOOK)
        try:
            yield
        finally:
            with suppress(OSError):  # Windows keeps open files
                path.unlink()


def _hash_file(library: Path) -> Path:
    return library.with_name(f"{library.name}.sha256")


def _is_whole(library: Path) -> bool:
    """Return whether a library is there, with the bytes that were written."""
    try:
        wanted = _hash_file(library).read_bytes()
        return hashlib.sha256(library.read_bytes()).hexdigest().encode() == wanted
    except OSError:
        return False


@cache
def _standalone() -> dict[str, str]:
    """Return what a Windows library without C runtime needs in its place."""
    folder = Path(__file__).parent / "standalone"
    text = {path.name: path.read_text(encoding="utf-8") for path in sorted(folder.iterdir())}
    return {name if name.endswith(".c") else f"system/{name}": t for name, t in text.items()}


def _digest(words: Sequence[str], trees: Iterable[Mapping[str, str]]) -> str:
    digest = hashlib.sha256("\0".join(words).encode())
    for path, text in chain.from_iterable(sorted(tree.items()) for tree in trees):
        digest.update(f"\0{path}\0{len(text)}\0{text}".encode())
    return digest.hexdigest()[:32]


def _check_exports(library: bytes, expected: Collection[str], name: str) -> None:
    exported = read_library(library).exports - _OF_THE_LINKER
    if lacking := sorted(set(expected) - exported):
        raise platforms.WrongExports(f"{name} does not export {', '.join(lacking)}")
    if foreign := sorted(exported - set(expected)):
        raise platforms.WrongExports(f"{name} exports {', '.join(foreign)}, not expected of it")


@cache
def compiler_version() -> str:
    """Return the version of ziglang; raise CompilerMissing where it is not installed."""
    if importlib.util.find_spec("ziglang") is None:
        what = "this needs the C compiler, package 'ziglang', which is not installed"
        raise platforms.CompilerMissing(f"{what}; run: {installing('compile')}")
    from importlib.metadata import version  # late, for those who start quickly

    return version("ziglang")


def _object(call: Sequence[str], files: Mapping[str, str]) -> dict[str, bytes]:
    """Return what is common, compiled, by name; it stays in the cache."""
    if not files:
        return {}
    command = [*call, "-c", *(path for path in files if path.endswith(".c"))]
    recipe = _digest([compiler_version(), *command[1:]], [files])
    return {_OBJECT: kept("objects", [recipe], lambda: _compile(command, files, _OBJECT))}


def _compile(command: Sequence[str], files: Mapping[str, str | bytes], output: str) -> bytes:
    zig = platforms.cache_directory() / "zig"
    environment = os.environ | {"ZIG_GLOBAL_CACHE_DIR": str(zig), "ZIG_LOCAL_CACHE_DIR": str(zig)}
    with temporary_folder("stickslip-build-") as folder:
        for path, text in files.items():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(text if isinstance(text, bytes) else text.encode())
        (folder / "system").mkdir(exist_ok=True)
        status, printed = _run([*command, "-o", output], folder, environment)
        if status != 0:
            if any(word in printed for word in _FULL):
                place = min(zig, folder, key=lambda path: shutil.disk_usage(path).free)
                raise _unusable(place, "no space left")
            if any(word in printed for word in _CLOSED):
                raise _unusable(zig, "cannot be written")
            said = printed.strip() or f"nothing, and ended with status {status}"
            what = f"cannot compile {output}; the compiler said:\n{said}"
            raise platforms.CompilationFailed(what)
        return (folder / output).read_bytes()


def _unusable(place: Path, why: str) -> platforms.CacheUnusable:
    advice, cached = platforms.CACHE_ADVICE, place.is_relative_to(platforms.cache_directory())
    if not cached and place.is_relative_to(tempfile.gettempdir()):
        advice = advice.replace("STICKSLIP_CACHE", "TMPDIR")
    return platforms.CacheUnusable(f"{place}: {why}; {advice}")


def _run(command: Sequence[str], folder: Path, environment: Mapping[str, str]) -> tuple[int, str]:
    """Run the compiler; return its status and what it printed. An interruption ends it."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with child_process(command, cwd=folder, env=environment, **pipes) as process:
        while True:
            check_interruption()
            with suppress(subprocess.TimeoutExpired):
                _, printed = process.communicate(timeout=_LOOK)
                return process.returncode, printed.decode(errors="replace")
