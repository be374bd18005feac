"""Answers come through a pipe, waited for in either way; nonsense is known as such."""

import json
import os
from queue import Empty

import pytest

from cosim.isolation.answers import NONSENSE, Answers, HeardAnswers, send


@pytest.mark.parametrize("kind", [Answers, HeardAnswers])
def test_answers_come_in_turn_then_none(kind):
    here, there = os.pipe()
    with os.fdopen(here, "rb", buffering=0) as pipe:
        answers = kind(pipe)
        with pytest.raises(Empty):
            answers.get(0.01)
        for n in range(3):
            send(there, json.dumps({"n": n}).encode())
        assert [answers.get(10.0) for _ in range(3)] == [{"n": n} for n in range(3)]
        os.close(there)
        assert answers.get(10.0) is None


@pytest.mark.parametrize("content", [b"x", b"\xff" * 100, b"\2" + bytes(7) + b"12"])
def test_nonsense_is_no_answer(content):
    here, there = os.pipe()
    with os.fdopen(here, "rb", buffering=0) as pipe:
        os.write(there, content)
        os.close(there)
        assert Answers(pipe).get(10.0) is NONSENSE
