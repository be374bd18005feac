"""Files that others add: one that fails is left out, and hurts nothing else.

They lie in the folders of the packages, in a clone, or in those of the user: ``laws``,
``compensators``, ``algorithms``, ``formats`` and ``commands`` in ``own_folder()``.
"""

import logging
import os
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


def own_folder() -> Path:
    """Return the folder of the user's additions: ``$STICKSLIP_ADDITIONS``, else in his home."""
    return Path(os.environ.get("STICKSLIP_ADDITIONS") or Path.home() / ".stickslip").absolute()


def modules_of(package: str, *names: str) -> list[ModuleType]:
    """Import the modules of a package and of the user; those that fail or lack a name are not."""
    found, paths = [], import_module(package).__path__
    own = str(own_folder() / package.rpartition(".")[2])
    if own not in paths:
        paths.append(own)
    for each in iter_modules(paths):
        path = getattr(each.module_finder, "path", own)
        with left_out(Path(path) / f"{each.name}.py", Exception):
            module = import_module(f"{package}.{each.name}")
            for name in names:
                getattr(module, name)
            found.append(module)
    return found
