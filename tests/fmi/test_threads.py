"""Futures of any pool."""

from __future__ import annotations

from concurrent.futures import Future
from threading import Event

from stickslip.fmi.process import cancel_all, threads


class Lost(Future[None]):
    """A future of a cluster that does not answer."""

    def cancel(self) -> bool:
        Event().wait()
        return True


class Broken(Future[None]):
    """A future of a cluster that was closed."""

    def cancel(self) -> bool:
        raise RuntimeError("closed")


def test_cancelling_ends_though_a_future_does_not_answer(monkeypatch):
    monkeypatch.setattr(threads, "PATIENCE", 0.1)
    waiting = [Future[None]() for _ in range(2)]
    cancel_all(one for one in (waiting[0], Broken(), waiting[1], Lost()))
    assert all(one.cancelled() for one in waiting)
