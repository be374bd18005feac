"""Files that others add to a folder: one that fails is left out, and hurts nothing else."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType


@contextmanager
def left_out(path: Path, *faults: type[Exception]) -> Iterator[None]:
    """Log in one line why an addition is left out, in place of raising."""
    try:
        yield
    except faults as fault:
        why = " ".join(f"{type(fault).__name__}: {fault}".split())
        logging.getLogger("stickslip").warning("%s is left out (%s); mend or remove it", path, why)


def modules_of(package: str, folder: Path, *names: str) -> list[ModuleType]:
    """Import the modules of a folder; those that fail or lack a name are left out."""
    found = []
    for each in iter_modules([str(folder)]):
        with left_out(folder / f"{each.name}.py", Exception):
            module = import_module(f"{package}.{each.name}")
            for name in names:
                getattr(module, name)
            found.append(module)
    return found
