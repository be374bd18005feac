"""The structures of ``general_path.h`` and the functions behind them."""

from __future__ import annotations

from ctypes import (
    POINTER,
    Structure,
    c_bool,
    c_char_p,
    c_double,
    c_float,
    c_int8,
    c_int16,
    c_int32,
    c_int64,
    c_size_t,
    c_uint8,
    c_uint16,
    c_uint32,
    c_uint64,
    c_void_p,
)

from stickslip.cosim.kernel import Answers, Log, load

# In the order of ``enum Stored``; other types are text.
STORED = (
    c_double,
    c_float,
    c_int8,
    c_uint8,
    c_int16,
    c_uint16,
    c_int32,
    c_uint32,
    c_int64,
    c_uint64,
    c_bool,
    c_char_p,
)
N_CALLS = 29


class Group(Structure):
    """Variables that one call gets or sets."""

    _fields_ = (
        ("call", c_void_p),
        ("name", c_char_p),
        ("stored", c_int64),
        ("discrete", c_int64),
        ("n", c_size_t),
        ("references", POINTER(c_uint32)),
        ("n_values", c_size_t),
        ("values", c_void_p),
        ("sizes", POINTER(c_size_t)),
    )


class Groups(Structure):
    """A list of groups."""

    _fields_ = (("n", c_size_t), ("groups", POINTER(Group)))


class Port(Structure):
    """A column of the kernel's rows: one element of one group."""

    _fields_ = (("group", c_int64), ("place", c_int64), ("ahead", c_int64))


class Course(Structure):
    """How an input runs over time."""

    _fields_ = (
        ("n", c_size_t),
        ("t", POINTER(c_double)),
        ("values", POINTER(c_double)),
        ("held", c_int64),
    )


class Clock(Structure):
    """An input clock that ticks by time."""

    _fields_ = (
        ("reference", c_uint32),
        ("asked", c_int32),
        ("interval", c_double),
        ("shift", c_double),
        ("begin", c_double),
        ("ticks", c_int64),
        ("next", c_double),
    )


class GeneralComponent(Structure):
    """An FMU seen by the kernel as a plain one."""

    _fields_ = (
        ("log", Log),
        ("version", c_int64),
        ("model_exchange", c_int64),
        ("event_mode", c_int64),
        ("notes_steps", c_int64),
        ("call", c_void_p * N_CALLS),
        ("structure", Groups),
        ("starts", Groups),
        ("late", Groups),
        ("inputs", Groups),
        ("outputs", Groups),
        ("input_ports", POINTER(Port)),
        ("output_ports", POINTER(Port)),
        ("n_inputs", c_size_t),
        ("before", POINTER(c_double)),
        ("after", POINTER(c_double)),
        ("follows", c_int64),
        ("rates", POINTER(c_double)),
        ("courses", POINTER(Course)),
        ("cvode", POINTER(c_void_p)),
        ("tolerance", c_double),
        ("told_tolerance", c_double),
        ("n_states", c_size_t),
        ("n_indicators", c_size_t),
        ("instance", c_void_p),
        ("integrator", c_void_p),
        ("called", c_char_p),
        ("time", c_double),
        ("start", c_double),
        ("stop", c_double),
        ("near", c_double),
        ("next_event", c_double),
        ("next_jump", c_double),
        ("passed", c_double),
        ("next_tick", c_double),
        ("n_clocks", c_size_t),
        ("clocks", POINTER(Clock)),
        ("running", c_int64),
        ("states_changed", c_int64),
        ("retries_steps", c_int64),
        ("begun", c_void_p),
        ("answers", Answers),
    )


def general_calls(version: int) -> list[tuple[str, str]]:
    """Return for each call its name, None where the version has none, and what needs it."""
    function = load().general_calls
    function.restype = c_char_p
    lines = function().decode().splitlines()
    return [(words[version - 2], words[2]) for words in map(str.split, lines)]


def cvode_calls() -> list[str]:
    """Return the names of the functions of SUNDIALS in the order of ``struct Cvode``."""
    function = load().cvode_calls
    function.restype = c_char_p
    names: bytes = function()
    return names.decode().split()
