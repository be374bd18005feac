"""C sources in, a shared library out."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path

from toolchain.cache import cache_directory, write_whole
from toolchain.errors import CompilationFailed, CompilerMissing
from toolchain.platforms import Platform, host_platform

# No fused multiply-add and a named target: the same bits on every processor.
# -O2 also keeps the compiler from linking its debug runtime (4 MB) into each library.
_FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared", "-s")
_WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")


def shared_library(
    name: str,
    files: Mapping[str, str],
    *,
    platform: Platform | None = None,
    flags: Sequence[str] = (),
) -> Path:
    """Compile the ``.c`` files among ``files`` into one shared library and return its path.

    The result lies in the cache under a hash of all that went in, so a second call returns at once.

    Parameters
    ----------
    name : file name of the library without ending
    files : relative path -> text of every source and header. Headers in ``system/`` are found
        with ``<...>`` and raise no warnings; the others are found from the root of the tree.
    platform : what to build for; the machine's own by default
    flags : further compiler flags. Those in ``$STICKSLIP_CFLAGS`` come last, such as a sanitizer's

    Raises
    ------
    CompilerMissing, CompilationFailed
    """
    target = platform or host_platform()
    command = [
        *(sys.executable, "-m", "ziglang", "cc", "-target", target.target),
        *(*_FLAGS, *_WARNINGS, *flags, "-I.", "-isystem", "system"),
        *os.environ.get("STICKSLIP_CFLAGS", "").split(),
        *sorted(path for path in files if path.endswith(".c")),
    ]
    if target.suffix == ".dylib":
        command.append(f"-Wl,-install_name,@rpath/{name}.dylib")
    key = _digest([_compiler_version(), name, *command[1:]], files)
    library = cache_directory() / "libraries" / key / (name + target.suffix)
    if not library.exists():
        write_whole(library, _compile(command, files, library.name))
    return library


def _digest(words: Sequence[str], files: Mapping[str, str]) -> str:
    digest = hashlib.sha256("\0".join(words).encode())
    for path, text in sorted(files.items()):
        digest.update(f"\0{path}\0{len(text)}\0{text}".encode())
    return digest.hexdigest()[:32]


@cache
def _compiler_version() -> str:
    if importlib.util.find_spec("ziglang") is None:
        raise CompilerMissing(
            "the C compiler is missing: package 'ziglang' is not installed; "
            "run 'pip install ziglang'"
        )
    return version("ziglang")


def _compile(command: Sequence[str], files: Mapping[str, str], output: str) -> bytes:
    zig = cache_directory() / "zig"
    environment = os.environ | {
        "ZIG_GLOBAL_CACHE_DIR": str(zig),
        "ZIG_LOCAL_CACHE_DIR": str(zig),
    }
    with tempfile.TemporaryDirectory(prefix="stickslip-build-") as folder:
        for path, text in files.items():
            file = Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        Path(folder, "system").mkdir(exist_ok=True)
        done = subprocess.run(
            [*command, "-o", output], cwd=folder, env=environment, capture_output=True, text=True
        )
        if done.returncode != 0:
            said = done.stderr.strip() or f"nothing, and ended with status {done.returncode}"
            raise CompilationFailed(f"cannot compile {output}; the compiler said:\n{said}")
        return Path(folder, output).read_bytes()
