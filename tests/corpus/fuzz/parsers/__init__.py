"""What is fuzzed, one module each.

EXPECTED: tuple of the exceptions by which an input may be refused
corpus() -> list[bytes]                valid inputs, from which all others are made
parse(data: bytes, folder: Path)       reads one; removes whatever it wrote into the folder
mutate(rng: Random, data) -> bytes     optional: changes that keep the structure; half of all
                                       inputs go through it, the other half through bytes alone
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from random import Random
from typing import Protocol

NAMES = sorted(module.name for module in pkgutil.iter_modules(__path__))
Mutate = Callable[[Random, bytes], bytes]


class Parser(Protocol):
    EXPECTED: tuple[type[Exception], ...]

    def corpus(self) -> list[bytes]: ...
    def parse(self, data: bytes, folder: Path) -> None: ...


def load(name: str) -> Parser:
    return import_module(f"{__name__}.{name}")
