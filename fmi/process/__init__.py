"""Processes: signals, threads, child processes and standard streams."""

from stickslip.fmi.process.child import child_process, open_standard_streams
from stickslip.fmi.process.interruption import (
    check_interruption,
    held,
    interrupted_by,
    interruptible,
    temporary_folder,
)
from stickslip.fmi.process.threads import Threads, cancel_all, result_of, wait_first

__all__ = [
    "Threads",
    "cancel_all",
    "check_interruption",
    "child_process",
    "held",
    "interrupted_by",
    "interruptible",
    "open_standard_streams",
    "result_of",
    "temporary_folder",
    "wait_first",
]
