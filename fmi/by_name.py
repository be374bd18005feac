"""Values that a caller gives by name, in whatever form his tools have them."""

from collections.abc import Mapping
from typing import Any

from stickslip.fmi.errors import Fault
from stickslip.fmi.messages import printable


def by_name(what: str, given: Any, error: type[Fault], also: str = "") -> dict[str, Any]:
    """Return what is given by name as a dictionary, an empty one for None.

    It is a mapping, a series or one-row data frame of pandas, or a named tuple, as ``itertuples``
    returns of a data frame. ``what`` it is, and what is expected ``also``, are for messages.
    ``error`` when it is something else, or a name is not a text or occurs twice.
    """
    if given is None:
        return {}
    if hasattr(given, "_asdict"):
        rows = type(given).__name__ == "Pandas"
        pairs = [one for one in given._asdict().items() if not (rows and one[0] == "Index")]
        if renamed := [name for name, _ in pairs if name.startswith("_")]:
            why = f"itertuples called a column {renamed[0]}, as its name is no identifier of Python"
            raise error(f"{what}: {why}; give the row as table.iloc[0]")
    elif hasattr(given, "columns") and hasattr(given, "iloc"):
        if len(given) != 1:
            why = f"expected a dictionary, or a data frame of one row, got one of {len(given)}"
            advice = "see table.iloc[0], or table.to_dict('list') for lists of values"
            raise error(f"{what}: {why}; {advice}")
        pairs = [(name, column.iloc[0]) for name, column in given.items()]
    elif isinstance(given, Mapping) or hasattr(given, "iloc"):
        pairs = [*given.items()]
    else:
        got = printable(repr(given), 80)
        raise error(f"{what}: expected a dictionary with a name for each{also}, got {got}")
    if other := [name for name, _ in pairs if not isinstance(name, str)]:
        got = printable(repr(other[0]), 80)
        raise error(f"{what}: expected each by its name, as {{'name': ...}}, got {got}")
    found = dict(pairs)
    if len(found) < len(pairs):
        raise error(f"{what}: a name comes twice: {', '.join(name for name, _ in pairs)}")
    return found
