"""Compiles C for any platform with the ``ziglang`` package, into a cache addressed by content.

It knows C files and platforms. What came with the package needs no compiler.
"""

from stickslip.fmi.toolchain.binaries import binaries, patched, standard_functions
from stickslip.fmi.toolchain.compiler import compiled_here, compiler_version, shared_library
from stickslip.fmi.toolchain.keeping import kept
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
    chosen_platforms,
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
    "chosen_platforms",
    "compiled_here",
    "compiler_version",
    "host_platform",
    "kept",
    "patched",
    "shared_library",
    "standard_functions",
]
