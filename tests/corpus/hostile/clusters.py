"""Group 30: clusters, caches and consoles that fail a command."""

from tests.corpus.hostile import fmus
from tests.corpus.hostile.case import Case, Content

_COMMAND = """
import contextlib, os, sys
from unittest.mock import patch
with patch.dict(os.environ, {{{!r}: {!r}}}), {} as stderr, contextlib.redirect_stderr(stderr):
    sys.exit(main(["simulate", "h.fmu", "--set", {!r}]))
"""


def _process(
    name: str,
    about: str,
    says: str,
    variable: str,
    value: str,
    *,
    behaviour: str = "",
    stderr: str = "contextlib.nullcontext(sys.stderr)",
    parameter: str = "k=1",
    **others: Content,
) -> Case:
    """Return a case of a run with a variable of its environment."""
    files = {f"{other}.py": text for other, text in others.items()}
    files["h.fmu"] = lambda path: fmus.write(path, behaviour)
    code = _COMMAND.format(variable, value, stderr, parameter)
    return Case(30, name, about, says, "", files, code)


CASES = [
    Case(30, "address", "no address of a cluster", r".*'yonder'; expected the address of a scheduler", "arena --out a --cluster yonder"),
    _process("sitecustomize", "a crash where Python prints as it starts", r"hostile \(h\.fmu\): fmi2DoStep died of SIGSEGV", "PYTHONPATH", ".", behaviour="DoStep segv 2", sitecustomize='print("printed first")'),
    _process("console", "a name that the console cannot encode", r".*\\u03b1", "PYTHONUTF8", "0", stderr='open(2, "w", encoding="ascii", closefd=False)', parameter="\u03b1=1"),
    _process("cache-is-a-file", "the cache is a file", r".*set STICKSLIP_CACHE to a folder", "STICKSLIP_CACHE", "h.fmu"),
]  # fmt: skip
