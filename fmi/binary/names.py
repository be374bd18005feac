"""Names in a library's tables; a hostile one has them without end."""

from __future__ import annotations

MOST_SYMBOLS = 500_000
"""In a table; the largest libraries have a tenth of them."""
MOST_COMMANDS = 10_000
"""In the dynamic segment of ELF, and of Mach-O: some dozens are usual."""
MOST_SECTIONS = 96
"""Of PE: Windows loads no more."""
MOST_NAMES = 65_536
"""Of functions in PE, which have ordinals of 16 bits."""

_LONGEST = 4096  # bytes of a name
_MOST_TEXT = 2**25  # bytes of all names


class Names:
    """The strings of a library, which end with a zero byte."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._left = _MOST_TEXT

    def at(self, place: int) -> str:
        """Return the name that begins at a byte; ValueError where names are too long."""
        end = self._data.find(b"\0", place, place + _LONGEST)
        if end < 0:
            raise ValueError(f"a name at byte {place:#x} that does not end within {_LONGEST} bytes")
        self._left -= end - place
        if self._left < 0:
            raise ValueError(f"names of more than {_MOST_TEXT} bytes")
        return self._data[place:end].decode("latin-1")


def checked(count: int, what: str, most: int = MOST_SYMBOLS) -> int:
    """Return a number that a header states; ValueError where no library has so many."""
    if count > most:
        raise ValueError(f"{count} {what}; at most {most} are read")
    return count
