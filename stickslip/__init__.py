"""stickslip learns a friction compensator for a servo drive, in FMUs.

>>> import stickslip as ss
>>> system = ss.System("loop")
>>> result = ss.simulate("drive.fmu", stop=2.0, inputs={"u": 1.0})
>>> learned = ss.learn("log.csv")

The public names are those of ``__init__.pyi``, loaded when they are first used.
Below are the packages: ``stickslip.cosim`` couples and steps FMUs, ``stickslip.ga`` optimises,
``stickslip.models`` builds FMUs, ``stickslip.fmucheck`` checks them, ``stickslip.servo`` designs
velocity loops. The errors of the application are drawn in ``stickslip/errors.py``.
"""

import re
from importlib import import_module
from pathlib import Path

if not Path(__file__).with_name("models").exists():
    __path__.append(str(Path(__file__).parents[1]))  # in a clone, packages lie beside this one
_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_PLACE = {
    name: place for place, name in re.findall(r"^from (\S+) import (\w+)", _STUB, re.MULTILINE)
}

__all__ = [*_PLACE]


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name == "__version__":
        from importlib.metadata import version  # late, for those who start quickly

        return version("stickslip")
    if name not in _PLACE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if _PLACE[name] == __name__:
        return import_module(f"{__name__}.{name}")
    value = getattr(import_module(_PLACE[name]), name)
    from stickslip.arguments import public  # late, as above

    globals()[name] = value = public(value)
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
