"""Answers come through a pipe, waited for in either way; nonsense is known as such."""

import json
import os
import struct
import threading
import time
import zlib
from contextlib import contextmanager
from queue import Empty

import pytest

from stickslip.cosim.isolation.messages import (
    NONSENSE,
    Answers,
    ThreadedAnswers,
    message,
    receive,
    send,
)

TOKEN = bytes(range(16))
KINDS = pytest.mark.parametrize("kind", [Answers, ThreadedAnswers])


@contextmanager
def connected(kind):
    """Give the parent's answers, where the child writes them, and where it reads requests."""
    (replies, write), (read, requests) = os.pipe(), os.pipe()
    answers = kind(requests, replies, TOKEN)
    try:
        yield answers, write, read
    finally:
        os.close(write)
        if answers.get(10.0) is NONSENSE:
            while answers._part(time.monotonic() + 10.0):  # until the thread that reads has ended
                pass
        for file in (replies, read, requests):
            os.close(file)


@KINDS
def test_answers_come_in_turn_then_none(kind):
    with connected(kind) as (answers, write, _):
        with pytest.raises(Empty):
            answers.get(0.01)
        for n in range(3):
            send(write, TOKEN, json.dumps({"n": n}).encode())
        assert [answers.get(10.0) for _ in range(3)] == [{"n": n} for n in range(3)]


@KINDS
@pytest.mark.parametrize("n", [1, 15, 16, 20, 30, 40])
def test_a_part_of_an_answer_is_not_waited_for_any_longer(kind, n):
    whole = message(TOKEN, b'{"n": 123456}')
    with connected(kind) as (answers, write, _):
        os.write(write, whole[:n])
        with pytest.raises(Empty):
            answers.get(0.05)
        os.write(write, whole[n:])
        assert answers.get(10.0) == {"n": 123456}


def _framed(content: bytes, token: bytes = TOKEN, check: int | None = None) -> bytes:
    check = zlib.crc32(content) if check is None else check
    return struct.pack("<16sQL", token, len(content), check) + content


@KINDS
@pytest.mark.parametrize(
    "content",
    [
        b"x", b"\xff" * 100, b"\2" + bytes(7) + b"{}", bytes(100), _framed(b"{}", token=bytes(16)),
        _framed(b"{}", check=0), _framed(b"5"), _framed(b"\xff\xfe"), _framed(b"[" * 100_000),
        struct.pack("<16sQL", TOKEN, 2**40, 0),
    ],
)  # fmt: skip
def test_nonsense_is_no_answer(kind, content):
    """But for what Python prints as it starts, before the first answer."""
    with connected(kind) as (answers, write, _):
        os.write(write, b"printed by a sitecustomize\n")
        send(write, TOKEN, b"{}")
        assert answers.get(10.0) == {}
        os.write(write, content[:60_000])
        if len(content) > 60_000:
            threading.Thread(target=os.write, args=(write, content[60_000:])).start()
        assert answers.get(10.0) is NONSENSE


@KINDS
def test_a_request_that_nobody_reads_blocks_nobody(kind):
    request = os.urandom(2**20)
    with connected(kind) as (answers, write, read):
        answers.send(request)
        with pytest.raises(Empty):
            answers.get(0.05)
        seen = []

        def child() -> None:
            seen.append(receive(read, TOKEN))
            send(write, TOKEN, b'{"heard": true}')

        threading.Thread(target=child).start()
        assert answers.get(30.0) == {"heard": True}
        assert seen == [request]


@pytest.mark.parametrize("content", [b"", b"x", bytes(100), _framed(b"{}", check=0)])
def test_what_is_not_a_request_is_an_error(content):
    read, write = os.pipe()
    os.write(write, content)
    os.close(write)
    with pytest.raises(OSError, match="expected a message"):
        receive(read, TOKEN)
    os.close(read)
