"""TOML files of the user: read with limits, keys and values checked with one line for a fault."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from stickslip.errors import UsageError
from stickslip.fmi.files import MOST_TEXT, parse_toml, read_limited
from stickslip.fmi.messages import suggestion


def is_number(value: object) -> bool:
    """Whether a value is a number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def list_of(value: object, is_element: Callable[[object], bool]) -> bool:
    """Whether a value is a list of such elements."""
    return isinstance(value, list) and all(map(is_element, value))


Kind = tuple[Callable[[Any], bool], str]  # tells whether a value fits, and what is expected
TEXT: Kind = (lambda value: isinstance(value, str), "a text")
NUMBER: Kind = (is_number, "a number")
WHOLE: Kind = (lambda value: type(value) is int, "a whole number")
PAIR: Kind = (lambda value: list_of(value, is_number) and len(value) == 2, "[lowest, highest]")
TABLE: Kind = (lambda value: isinstance(value, dict), "a table")


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a file; raise UsageError when it cannot be read, or is not TOML."""
    try:
        return parse_toml(read_limited(path, MOST_TEXT))
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:  # not UTF-8, or not TOML
        raise UsageError(f"{path}: not TOML ({' '.join(str(error).split())})") from None


def checked(table: Mapping[str, Any], kinds: Mapping[str, Kind], place: str = "") -> dict[str, Any]:
    """Return a table whose keys and values are of these kinds, or raise; lists become tuples."""
    for key, value in table.items():
        if key not in kinds:
            raise UsageError(f"no key '{place}{key}'{suggestion(key, kinds)}")
        fits, expected = kinds[key]
        if not fits(value):
            raise UsageError(f"{place}{key} = {value!r}: expected {expected}")
    return {key: tuple(value) if isinstance(value, list) else value for key, value in table.items()}
