"""Compiles C for any platform with the ``ziglang`` package, into a cache addressed by content.

It knows C files and platforms. What came with the package needs no compiler.

    Fault                       base of all errors that a user can cause, in ``fmi.errors``
    ToolchainError(RuntimeError)
        CompilerMissing     the ``ziglang`` package is not installed
        CompilationFailed   the compiler rejected the sources; carries its output
        CacheUnusable       the folder of built or of temporary files cannot be written
        WrongExports        a library does not export the requested functions
"""

from stickslip.fmi.toolchain.binaries import binaries, patched, standard_functions
from stickslip.fmi.toolchain.compiler import compiled_here, compiler_version, shared_library
from stickslip.fmi.toolchain.platforms import (
    CACHE_ADVICE,
    PLATFORMS,
    CacheUnusable,
    CompilationFailed,
    CompilerMissing,
    Platform,
    ToolchainError,
    WrongExports,
    cache_directory,
    host_platform,
)

__all__ = [
    "CACHE_ADVICE",
    "PLATFORMS",
    "CacheUnusable",
    "CompilationFailed",
    "CompilerMissing",
    "Platform",
    "ToolchainError",
    "WrongExports",
    "binaries",
    "cache_directory",
    "compiled_here",
    "compiler_version",
    "host_platform",
    "patched",
    "shared_library",
    "standard_functions",
]
