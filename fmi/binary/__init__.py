"""Shared libraries as files: ELF, PE and Mach-O, read without loading them."""

from stickslip.fmi.binary.interface import Interface, NotALibrary, interface
from stickslip.fmi.binary.universal import universal

__all__ = ["Interface", "NotALibrary", "interface", "universal"]
