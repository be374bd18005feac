"""Group 30: clusters, caches and consoles that fail a command."""

from tests.corpus.hostile import fmus
from tests.corpus.hostile.case import Case, Content

_LOST = """
import asyncio, dask, distributed, tempfile, threading
from unittest.mock import patch
from stickslip import ga
def cost(values):
    return float(values @ values)
with (
    patch("stickslip.ga.execution.cluster.ANSWER", 0.5),
    tempfile.TemporaryDirectory() as scratch,
    dask.config.set(temporary_directory=scratch),
    distributed.LocalCluster(
        n_workers=1, processes=False, dashboard_address=":0", silence_logs=60
    ) as lost,
    ga.executor(lost.scheduler_address, 1) as executor,
):
    HARM
    problem = ga.Problem([ga.Gene("a", 0.1, 1.0, 0.5)])
    ga.learn(ga.optimiser("default", problem, ga.Limits(generations=10**6)), cost, executor)
"""
_COMMAND = """
import contextlib, os, sys
from unittest.mock import patch
with patch.dict(os.environ, {{{!r}: {!r}}}), {} as stderr, contextlib.redirect_stderr(stderr):
    sys.exit(main(["simulate", "h.fmu", "--set", {!r}]))
"""


def _lost(name: str, about: str, says: str, harm: str) -> Case:
    return Case(30, name, about, says, "", code=_LOST.replace("HARM", harm))


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
    Case(30, "address", "no address of a cluster", r".*'yonder'; expected local or the address of a scheduler", "arena --out a --cluster yonder"),
    _lost("closed", "the scheduler ends in the midst of learning", "the connection to the Dask scheduler at .* is lost", "threading.Timer(1.0, lost.close).start()"),
    _lost("stopped", "the scheduler does not answer any more", "the Dask scheduler at .* has not answered for 0.5 s", 'lost.scheduler.handlers["ncores"] = lambda **_: asyncio.sleep(5.0)'),
    _process("sitecustomize", "a crash where Python prints as it starts", r"hostile \(h\.fmu\): fmi2DoStep died of SIGSEGV", "PYTHONPATH", ".", behaviour="DoStep segv 2", sitecustomize='print("printed first")'),
    _process("console", "a name that the console cannot encode", r".*\\u03b1", "PYTHONUTF8", "0", stderr='open(2, "w", encoding="ascii", closefd=False)', parameter="\u03b1=1"),
    _process("cache-is-a-file", "the cache is a file", r".*set STICKSLIP_CACHE to a folder", "STICKSLIP_CACHE", "h.fmu"),
]  # fmt: skip
