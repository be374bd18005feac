"""What is fuzzed."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random

from campaigns.fuzz.mutation import by_tokens

Parse = Callable[[bytes, Path], object]


@dataclass(frozen=True)
class Parser:
    """A parser.

    Attributes
    ----------
    parse : reads an input; removes what it writes into the folder
    corpus : gives valid inputs, from which all others are made
    change : a change that keeps the structure, for half of the inputs; the others are changed as
        bytes
    expected : the exceptions by which an input may be refused
    """

    parse: Parse
    corpus: Callable[[], list[bytes]]
    change: Callable[[Random, bytes], bytes]
    expected: tuple[type[Exception], ...]


def from_file(name: str, read: Callable[[Path], object]) -> Parse:
    """Return a parser of the content of a file of this name."""

    def parse(data: bytes, folder: Path) -> None:
        (folder / name).write_bytes(data)
        read(folder / name)

    return parse


def text(
    name: str,
    read: Callable[[Path], object],
    words: tuple[bytes, ...],
    corpus: list[bytes],
    *expected: type[Exception],
) -> Parser:
    """Return a parser of text files, whose words are replaced, moved and repeated."""
    change = partial(by_tokens, words=words)
    return Parser(from_file(name, read), lambda: corpus, change, expected)
