"""Changes of bytes without regard to their meaning, and of texts that leave words whole."""

import re
from collections.abc import Sequence
from random import Random

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
NUMBERS = (
    *(b"0", b"-0", b"1", b"-1", b"1e400", b"-1e400", b"1e-400", b"NaN", b"INF", b"-INF", b"inf"),
    *(b"2147483648", b"-2147483649", b"4294967296", b"18446744073709551616", b"9" * 5000),
    *(b"", b" ", b"0x10", b"1_000", b"1,5", b"1e", b".", b"true", "\u0661".encode()),
)
TOKENS = (
    *(b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xc3(", b"\r\n", b"\n", b'"', b"'", b"<", b"&", b"{"),
    *(b"../", b"C:\\", b"/", b"\\", b",", b";", b"=", b"[", b"]", b"A" * 300),
)


def mutated(rng: Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """Return the input with one to four changes."""
    for _ in range(rng.randint(1, 4)):
        data = rng.choice(_CHANGES)(rng, data, corpus)
    return data


def _place(rng: Random, data: bytes) -> tuple[int, int]:
    begin = rng.randint(0, len(data))
    return begin, min(len(data), begin + int(rng.expovariate(1 / 20)))


def _flip(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    if not data:
        return data
    changed, place = bytearray(data), rng.randrange(len(data))
    changed[place] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _overwrite(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    begin, end = _place(rng, data)
    return data[:begin] + rng.randbytes(end - begin) + data[end:]


def _remove(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    begin, end = _place(rng, data)
    return data[:begin] + data[end:]


def _repeat(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    begin, end = _place(rng, data)
    return data[:begin] + data[begin:end] * rng.choice((2, 3, 50)) + data[end:]


def _insert(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    place = rng.randint(0, len(data))
    return data[:place] + rng.choice(TOKENS) + data[place:]


def _cut(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    return data[: rng.randint(0, len(data))]


def _renumber(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    found = _NUMBER.search(data, rng.randint(0, len(data)))
    if found is None:
        return data
    return data[: found.start()] + rng.choice(NUMBERS) + data[found.end() :]


def _splice(rng: Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    other = rng.choice(corpus)
    begin, end = _place(rng, other)
    place = rng.randint(0, len(data))
    return data[:place] + other[begin:end] + data[place:]


_CHANGES = (_flip, _overwrite, _remove, _repeat, _insert, _cut, _renumber, _renumber, _splice)

_TOKEN = re.compile(rb"[\w.+-]+|\s+|.", re.DOTALL)


def by_tokens(rng: Random, data: bytes, words: Sequence[bytes]) -> bytes:
    """Return a text in which one to three stretches of words were replaced, moved or repeated.

    Parameters
    ----------
    words : of the language, beside the numbers that are hostile anywhere
    """
    tokens = _TOKEN.findall(data) or [b""]
    for _ in range(rng.randint(1, 3)):
        begin = rng.randrange(len(tokens) + 1)
        end = min(len(tokens), begin + int(rng.expovariate(1 / 4)))
        match rng.randrange(6):
            case 0:
                tokens[begin:end] = []
            case 1:
                tokens[begin:end] = tokens[begin:end] * rng.choice((2, 3, 40))
            case 2:
                place = rng.randrange(len(tokens) + 1)
                tokens[place:place] = tokens[begin:end]
            case 3:
                tokens[begin : begin + 1] = [rng.choice(NUMBERS)]
            case 4:
                tokens[begin:begin] = [rng.choice(words)]
            case _:
                tokens[begin : begin + 1] = [rng.choice(words)]
    return b"".join(tokens)
