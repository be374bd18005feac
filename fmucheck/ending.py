"""Rules about how the child process ended in which a binary was tried."""

import signal
from dataclasses import dataclass

from stickslip.fmucheck.rules import Claims, error, note, warning

TELLING = {"unknown-reference", "bad-step", "step-before-initialisation", "freeing-nothing"}
TELLING |= {"needs-a-logger"}
"""Rules that try what an FMU must withstand: when it does not, that is their finding."""
MOST_TEXT = 1_000_000  # bytes on standard output and error


@dataclass(frozen=True)
class Ending:
    """How a child ended."""

    interface: str
    during: str  # interface and rule that was being tried
    rule: str  # the one of this module that tells it
    status: int | None = None  # of exit, or minus the signal; None when the checker ended it
    text: str = ""  # what was printed, the beginning of it; or what failed, or why it was not run
    seconds: float = 0.0

    @property
    def place(self) -> str:
        """Where it happened."""
        return f"{self.interface}, while trying {self.during}" if self.during else self.interface


@error("2.1.3", "2.2.4", "run it under a debugger with these calls")
def crash(ending: Ending) -> Claims:
    """The binary crashes its process."""
    yield ending.place, f"the process died of {signal_name(ending.status)}"


def signal_name(status: int | None) -> str:
    """Return what ended a process."""
    try:
        return signal.Signals(-(status or 0)).name
    except ValueError:
        return f"status {status}"


@error("2.1.3", "2.2.4", "make the call work, or declare less")
def call_fails(ending: Ending) -> Claims:
    """A call fails that must succeed for what the description declares."""
    yield ending.place, ending.text


@error("2.1.3", "2.2.4", "return Error or Fatal instead of exit")
def ends_the_process(ending: Ending) -> Claims:
    """The binary ends its process, and with it any tool that loads it."""
    last = ending.text.strip().splitlines()[-1:] or ["nothing"]
    what = f"the process ended with status {ending.status} and printed: {last[0][:200]}"
    yield ending.place, what


@error("2.1.3", "2.2.4", "bound every loop, or allow more --timeout")
def hang(ending: Ending) -> Claims:
    """The binary does not return in the time allowed."""
    yield ending.place, f"did not return in {ending.seconds:g} s"


@error("2.1.5", "2.2.4", "use the logger")
def floods_output(ending: Ending) -> Claims:
    """The binary writes without end to standard output."""
    yield ending.place, f"wrote more than {MOST_TEXT} bytes"


@warning("2.1.5", "2.2.4", "use the logger")
def prints(ending: Ending) -> Claims:
    """The binary writes to standard output or error instead of to the logger."""
    yield ending.place, f"wrote {ending.text.strip()[:100]!r}"


@error("2.1.1", "2.2.1", "end in FreeInstance what was started")
def leaves_a_process(ending: Ending) -> Claims:
    """A process that the binary has started outlives its instances."""
    yield ending.place, "was still running when the FMU had been unloaded or ended"


@warning("2.1.1", "2.2.1", "document it, or do without; --allow network|exec|files=DIR|env=NAME")
def reaches_outside(ending: Ending) -> Claims:
    """The binary tries what the sandbox denies: files, the network, programs, processes."""
    yield ending.place, "was tried, and denied by the sandbox"


@error("2.3", "2.5", "leave the unpacked files as they are; write to a temporary folder")
def changes_its_files(ending: Ending) -> Claims:
    """The binary deletes, changes or adds files of its unpacked FMU."""
    yield ending.place, "was deleted, changed or added while it ran"


@warning("", "", "report it with the FMU: an error in stickslip")
def rule_not_tried(ending: Ending) -> Claims:
    """A rule could not be tried, because of an unexpected exception in stickslip."""
    yield ending.place, ending.text.strip().splitlines()[-1]


@note("", "", "correct the errors, or check it where it has a binary")
def not_run(ending: Ending) -> Claims:
    """The binary was not run, for the reason given."""
    yield ending.place, ending.text
