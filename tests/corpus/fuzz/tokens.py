"""Changes of texts that leave their words whole."""

from __future__ import annotations

import re
from collections.abc import Sequence
from random import Random

from tests.corpus.fuzz.mutation import NUMBERS

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
