"""What is wrong with a description, and where."""

from __future__ import annotations

from typing import Any


class DescriptionFault(ValueError):
    """A description that is not taken; the message begins with the line.

    Parameters
    ----------
    element : of the XML that is wrong
    what : what it is, what was expected, what to do
    """

    def __init__(self, element: Any, what: str) -> None:
        super().__init__(f"line {element.sourceline}: {what}")
