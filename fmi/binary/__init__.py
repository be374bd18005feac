"""Shared libraries as files: ELF, PE and Mach-O, read without loading them."""

from stickslip.fmi.binary.library import Library, NotALibrary, read_library
from stickslip.fmi.binary.universal import universal

__all__ = ["Library", "NotALibrary", "read_library", "universal"]
