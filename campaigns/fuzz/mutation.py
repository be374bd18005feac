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
    """Return the input with one to four stretches changed."""
    for _ in range(rng.randint(1, 4)):
        begin, end = _place(rng, data)
        part = data[begin:end]
        match rng.randrange(9):
            case 0:
                end = begin + 1
                part = bytes(byte ^ 1 << rng.randrange(8) for byte in data[begin:end])
            case 1:
                part = rng.randbytes(end - begin)
            case 2:
                part = b""
            case 3:
                part *= rng.choice((2, 3, 50))
            case 4:
                part = rng.choice(TOKENS) + part
            case 5:
                part, end = b"", len(data)
            case 6:
                other = rng.choice(corpus)
                first, last = _place(rng, other)
                part = other[first:last] + part
            case _ if found := _NUMBER.search(data, begin):
                begin, end = found.span()
                part = rng.choice(NUMBERS)
        data = data[:begin] + part + data[end:]
    return data


def _place(rng: Random, data: bytes) -> tuple[int, int]:
    begin = rng.randint(0, len(data))
    return begin, min(len(data), begin + int(rng.expovariate(1 / 20)))


_TOKEN = re.compile(rb"[\w.+-]+|\s+|.", re.DOTALL)


def by_tokens(rng: Random, data: bytes, words: Sequence[bytes]) -> bytes:
    """Return a text in which one to three stretches of words were replaced, moved or repeated.

    The words are those of the language, beside the numbers that are hostile anywhere.
    """
    tokens = _TOKEN.findall(data) or [b""]
    for _ in range(rng.randint(1, 3)):
        begin = rng.randrange(len(tokens) + 1)
        end = min(len(tokens), begin + int(rng.expovariate(1 / 4)))
        match rng.randrange(6):
            case 0:
                tokens[begin:end] = []
            case 1:
                tokens[begin:end] *= rng.choice((2, 3, 40))
            case 2:
                place = rng.randrange(len(tokens) + 1)
                tokens[place:place] = tokens[begin:end]
            case 3:
                tokens[begin:begin] = [rng.choice(words)]
            case _:
                tokens[begin : begin + 1] = [rng.choice(rng.choice((NUMBERS, words)))]
    return b"".join(tokens)
