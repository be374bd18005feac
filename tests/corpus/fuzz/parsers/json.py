"""``--parameters learned.json``, ``--resume`` of a checkpoint, ``export lti SYSTEM.json``."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from random import Random

from stickslip import ga
from stickslip.errors import UsageError
from stickslip.ga.execution import checkpoint
from stickslip.models.errors import LtiError
from stickslip.models.lti.file import read_lti
from stickslip.results.learned import LearnedFile
from tests.corpus.fuzz.tokens import by_tokens

EXPECTED = (UsageError, ga.StateError, LtiError)
_WORDS = (
    *(b"[", b"]", b"{", b"}", b":", b",", b'"', b'""', b"null", b"true", b"NaN", b"-Infinity"),
    *(
        b'"value"',
        b'"unit"',
        b'"F_c"',
        b'"loop"',
        b'"seed"',
        b'"evaluations"',
        b'"genes"',
        b"1e999",
    ),
    *(b'"\\ud800"', b'"\\u0000"', b"[" * 2000, b'{"a":' * 500, b'"feed"', b'"velocity"', b"0"),
)


def _algorithm() -> ga.Optimiser:
    genes = [ga.Gene("a", 0.0, 2.0, 1.0, linear=True), ga.Gene("b", 1.0, 10.0, 5.0, "m")]
    return ga.GeneticAlgorithm(genes, ga.Settings(population=4, surrogates=False), seed=7)


@cache
def _checkpoint() -> bytes:
    algorithm = _algorithm()
    for _ in range(2):
        algorithm.tell(algorithm.ask().sum(axis=1))
    return json.dumps({"about": "", **algorithm.state()}).encode()


def corpus() -> list[bytes]:
    learned = Path(__file__).parents[4] / "results" / "paper" / "learned.json"
    system = {"A": [[-1.0]], "B": [[1.0]], "C": [[1.0]], "D": [[0.0]], "inputs": {"u": "N"}}
    return [
        learned.read_bytes(),
        _checkpoint(),
        json.dumps(system).encode(),
        b'{"num": [1], "den": [1, 0.5], "dt": 0.1, "outputs": ["y"]}',
    ]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "in.json"
    file.write_bytes(data)
    if b"evaluations" in data and b"genes" in data:
        _algorithm().replay(checkpoint.read(file, ""))
    elif b"parameters" in data:
        learned = LearnedFile(file)
        for entry in ("compensator", "standard_errors", "feed", "loop", "validation", "datasheet"):
            getattr(learned, entry)
    else:
        read_lti(file)


def mutate(rng: Random, data: bytes) -> bytes:
    return by_tokens(rng, data, _WORDS)
