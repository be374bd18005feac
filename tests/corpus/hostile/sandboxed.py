"""Group 29: FMUs that reach for what is not theirs."""

from tests.corpus.hostile import fmus
from tests.corpus.hostile.case import Case

_LIMITED = ["simulate", "h.fmu", "--isolate", "--memory", "100"]


def _reaches(name: str, behaviour: str, about: str, says: str, *, harms: bool = False) -> Case:
    """Return a case of an FMU that tries something in its second step.

    Parameters
    ----------
    harms : whether it would harm what is outside; FMPy, which does not hinder it, is not tried
    """
    files = {"h.fmu": lambda path: fmus.write(path, f"DoStep {behaviour} 2")}
    code = f"import sys; sys.exit(main({_LIMITED}))" if harms else ""
    command = "" if harms else " ".join(_LIMITED)
    about += " (FMPy: not tried)" * harms
    return Case(29, name, about, r".*hostile \(h\.fmu\): fmi2DoStep " + says, command, files, code)


CASES = [
    _reaches("home", "read_home", "reads the home folder", "tried to read .*, which the sandbox denies"),
    _reaches("kill-parent", "kill_parent", "kills the process that started it", r"tried to send a signal to process \d+, which the sandbox denies", harms=True),
    _reaches("share", "share", "takes all memory as shared mappings", "took more than the 100 MB it may"),
]  # fmt: skip
