"""Errors of the toolchain; the tree is drawn in ``fmi/toolchain/__init__.py``."""


class Fault(Exception):
    """What a user can cause, in whatever package: the command says it in one line."""


class ToolchainError(Fault, RuntimeError):
    """Something between C sources and a shared library went wrong."""


class CompilerMissing(ToolchainError):
    """The ``ziglang`` package, which carries the compiler, is not installed."""


class CompilationFailed(ToolchainError):
    """The compiler refused the sources. The message ends with what it said."""


class WrongExports(ToolchainError):
    """The linker left out a function, or exported one that nobody asked for."""


class NotALibrary(ToolchainError, ValueError):
    """The bytes are no shared library that can be read."""
