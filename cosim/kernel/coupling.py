"""The structures of ``coupling.h``."""

from __future__ import annotations

from ctypes import POINTER, Structure, c_double, c_int32, c_int64, c_uint32, c_void_p

MAX_DEGREE = 2
MAX_PAST = MAX_DEGREE + 1


class Link(Structure):
    """What one input follows."""

    _fields_ = (
        ("column", c_int64),
        ("fresh", c_int64),
        ("feeds_through", c_int64),
        ("holds", c_int64),
    )


class Member(Structure):
    """What a component needs beyond ``kernel.Component``."""

    _fields_ = (
        ("links", POINTER(Link)),
        ("values", POINTER(c_double)),
        ("interpolates", c_int64),
        ("splits", c_int64),
        ("derivative_references", POINTER(c_uint32)),
        ("derivative_orders", POINTER(c_int32)),
        ("derivatives", POINTER(c_double)),
        ("set_derivatives", c_void_p),
        ("save", c_void_p),
        ("discard", c_void_p),
        ("restore", c_void_p),
        ("state", c_void_p),
        ("outputs", POINTER(c_double)),
        ("again", POINTER(c_double)),
        ("proven", c_int64),
        ("every", c_int64),
    )


class Loop(Structure):
    """Components that are solved together."""

    _fields_ = (
        ("first", c_int64),
        ("end", c_int64),
        ("n", c_int64),
        ("columns", POINTER(c_int64)),
        ("nominal", POINTER(c_double)),
        ("tolerance", c_double),
        ("max_iterations", c_int64),
        ("inverse", POINTER(c_double)),
        ("known", c_int64),
        ("work", POINTER(c_double)),
        ("rollback", c_int64),
        ("worst", c_int64),
        ("change", c_double),
    )


class Coupling(Structure):
    """How the components of a run are coupled."""

    _fields_ = (
        ("members", POINTER(Member)),
        ("n_members", c_int64),
        ("loops", POINTER(Loop)),
        ("n_loops", c_int64),
        ("degree", c_int64),
        ("past", POINTER(c_double)),
        ("next", POINTER(c_double)),
        ("times", c_double * MAX_PAST),
        ("n_past", c_int64),
        ("tolerance", c_double),
        ("min_step", c_double),
        ("inner", c_double),
        ("nominal", POINTER(c_double)),
        ("steps", c_int64),
        ("sweeps", c_int64),
        ("rejected", c_int64),
        ("t", c_double),
        ("h", c_double),
        ("share", c_double),
        ("swept", c_int64),
        ("given", POINTER(c_double)),
        ("ends", c_void_p),
    )
