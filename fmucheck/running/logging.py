"""Rules about messages."""

from __future__ import annotations

from collections.abc import Iterator
from ctypes import c_bool, c_char_p, c_int, c_size_t

from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed, Message, status_name
from stickslip.fmucheck.running.run import finished


def _messages(bench: Bench) -> Iterator[Message]:
    """Yield the messages of a plain run."""
    yield from finished(bench).instance.callbacks.messages


@warning("2.2.4", "2.4.5", "list it in LogCategories")
def undeclared_category(bench: Bench) -> Claims:
    """A message has a category that LogCategories does not list."""
    known = {*bench.description.categories, "", None}
    for category in dict.fromkeys(m.category for m in _messages(bench)):
        if category not in known:
            yield "LogCategories", f"category {category} is used, but not listed"


@warning("2.1.5", "2.2.4", "pass text, category and a known status")
def bad_message(bench: Bench) -> Claims:
    """A message has a null pointer or an unknown status."""
    for m in _messages(bench):
        if m.text is None or m.category is None or not 0 <= m.status <= 5:
            yield "logger", f"status {status_name(m.status)}, category {m.category}, text {m.text}"
            return


@warning("2.1.5", "2.3.1", "pass the pointer that the FMU was given when it was instantiated")
def foreign_environment(bench: Bench) -> Claims:
    """The logger is called with an environment that is not the importer's."""
    callbacks = finished(bench).instance.callbacks
    for m in callbacks.messages:
        if m.environment != callbacks.environment:
            place = hex(m.environment) if m.environment else "NULL"
            yield "logger", f"the environment is {place}, expected {hex(callbacks.environment)}"
            return


@warning("2.1.5", "2.2.4", "log only when it is switched on")
def logs_when_off(bench: Bench) -> Claims:
    """A plain run without logging logs something other than an error."""
    messages = finished(bench, bench.new(logging=False)).instance.callbacks.messages
    idle = [m for m in messages if m.status < 3]
    if idle:
        yield "logger", f"{len(idle)} messages, the first: {idle[0].text}"


@error("2.1.5", "2.3.1", "accept every category of LogCategories")
def debug_logging_fails(bench: Bench) -> Claims:
    """SetDebugLogging fails for the categories that are listed."""
    names = [c_char_p(name.encode()) for name in bench.description.categories]
    array = (c_char_p * max(len(names), 1))(*names)
    on = (c_int if bench.description.version == 2 else c_bool)(True)
    status = bench.new().status("SetDebugLogging", on, c_size_t(len(names)), array)
    yield from bench.failed("SetDebugLogging", status)


@error(None, "2.3.1", "check the pointer before calling it")
def needs_a_logger(bench: Bench) -> Claims:
    """It fails without a logger, which may be NULL."""
    instance = bench.instantiate(logger=False)
    if instance is None:
        yield bench.interface.kind, "gives no instance when logMessage is NULL"
        return
    try:
        finished(bench, instance)
    except CallFailed as failed:
        yield bench.interface.kind, f"{failed} when logMessage is NULL"
    bench.instantiate(token="{00000000-wrong-token}", logger=False)  # noqa: S106 (no secret)
