"""Parsers, and many inputs to one of them, counted."""

import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from random import Random

from campaigns.fuzz.mutation import by_tokens, mutated

Parse = Callable[[bytes, Path], object]


@dataclass(frozen=True)
class Parser:
    """A parser, and inputs for it."""

    parse: Parse  # reads an input; removes what it writes into the folder
    corpus: Callable[[], list[bytes]]  # gives valid inputs, from which all others are made
    # keeps the structure, for half of the inputs; the others are changed as bytes
    change: Callable[[Random, bytes], bytes]
    expected: tuple[type[Exception], ...]  # by which an input may be refused


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


SLOW = 2.0  # s of the processor for one input


@dataclass
class Tally:
    """What came of the inputs; ``unexpected`` and ``slow`` should stay empty."""

    inputs: int = 0
    accepted: int = 0
    refused: int = 0
    unexpected: list[str] = field(default_factory=list)
    slow: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        return (
            f"{self.inputs} inputs: {self.accepted} accepted, {self.refused} refused,"
            f" {len(self.unexpected)} unexpected, {len(self.slow)} slow"
        )


def made(parser: Parser, corpus: list[bytes], seed: int, i: int) -> bytes:
    """Return input i, which depends on the seed and i alone."""
    rng = Random(seed * 2**40 + i)  # noqa: S311 - no secrets
    data = rng.choice(corpus)
    if rng.random() < 0.5:
        return bytes(parser.change(rng, data))
    return mutated(rng, data, corpus)


def run(
    parser: Parser, seed: int, first: int, last: int, folder: Path, found: Path | None = None
) -> Tally:
    """Feed inputs first .. last - 1; in ``folder``, which is empty, the parser may write.

    ``found`` is the folder for inputs that end otherwise than they should.
    """
    tally, corpus = Tally(), parser.corpus()
    for i in range(first, last):
        data = made(parser, corpus, seed, i)
        begin = time.process_time()
        try:
            parser.parse(data, folder)
            tally.accepted += 1
        except parser.expected:
            tally.refused += 1
        except (Exception, RecursionError) as fault:  # noqa: BLE001 - this is what is looked for
            place = traceback.extract_tb(fault.__traceback__)[-1]
            where = f"{Path(place.filename).name}:{place.lineno}"
            tally.unexpected.append(f"{i}: {type(fault).__name__} at {where}: {fault}")
            _save(found, i, data)
        if time.process_time() - begin > SLOW:
            tally.slow.append(f"{i}: {time.process_time() - begin:.1f} s")
            _save(found, i, data)
        tally.inputs += 1
    return tally


def _save(found: Path | None, i: int, data: bytes) -> None:
    if found is not None:
        (found / f"{i}.bin").write_bytes(data)
