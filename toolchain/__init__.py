"""Compiles C for any platform with the ``ziglang`` package, into a cache addressed by content.

The ground floor of the house: it knows C files and platforms, nothing of FMI or friction.

    ToolchainError(RuntimeError)
        CompilerMissing     the ``ziglang`` package is not installed
        CompilationFailed   the compiler refused the sources; carries its output
"""

from toolchain.cache import cache_directory, write_whole
from toolchain.compiler import shared_library
from toolchain.errors import CompilationFailed, CompilerMissing, ToolchainError
from toolchain.platforms import PLATFORMS, Platform, host_platform

__all__ = [
    "PLATFORMS",
    "CompilationFailed",
    "CompilerMissing",
    "Platform",
    "ToolchainError",
    "cache_directory",
    "host_platform",
    "shared_library",
    "write_whole",
]
