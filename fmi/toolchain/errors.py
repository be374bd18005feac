"""Errors of the toolchain; the tree is drawn in ``fmi/toolchain/__init__.py``."""

from stickslip.fmi.errors import Fault


class ToolchainError(Fault, RuntimeError):
    """Building a shared library from C sources failed."""


class CompilerMissing(ToolchainError):
    """Something has to be compiled, and the ``ziglang`` package, the compiler, is not installed."""


class CompilationFailed(ToolchainError):
    """The compiler rejected the sources. The message ends with its output."""


class CacheUnusable(ToolchainError):
    """The folder of built files, or the one for temporary files, cannot be written."""


class WrongExports(ToolchainError):
    """The library lacks a requested function, or exports one that was not requested."""
