"""Rules without which nothing else can be tried: it loads, instantiates and runs."""

from __future__ import annotations

from ctypes import c_char_p

from stickslip.fmucheck.rules import Claims, error, note, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.run import finished

LOADING = {"does-not-load", "wrong-version-string", "refuses-its-token", "accepts-any-token"}
"""All that is tried of Scheduled Execution."""

GATES = ("does-not-load", "refuses-its-token", "does-not-run")
"""When one of these finds something, the rules after it are not tried."""


@error("2.3", "2.5.1.4", "build it for an older system, linked statically")
def does_not_load(bench: Bench) -> Claims:
    """The system cannot load the binary."""
    try:
        _ = bench.binary
    except OSError as fault:
        yield bench.library.name, str(fault)


@error("2.1.4", "2.2", "return the version of the headers")
def wrong_version_string(bench: Bench) -> Claims:
    """GetVersion returns another version than the description claims."""
    returned = bench.binary.function("GetVersion", c_char_p)()
    expected = bench.description.root.get("fmiVersion", "")
    if (returned or b"").decode("latin-1") != expected:
        yield bench.library.name, f"GetVersion returns {returned!r}; expected {expected}"


@error("2.1.4", None, "return 'default'")
def wrong_types_platform(bench: Bench) -> Claims:
    """fmi2GetTypesPlatform does not return the types this tool and all others use."""
    returned = bench.binary.function("GetTypesPlatform", c_char_p)()
    if returned != b"default":
        yield bench.library.name, f"returns {returned!r}; expected 'default'"


@error("2.1.5", "2.3.1", "build binary and description together")
def refuses_its_token(bench: Bench) -> Claims:
    """It gives no instance for the token in its own description."""
    if bench.instantiate() is None:
        yield bench.library.name, f"no instance for token {bench.description.token}"


@warning("2.1.5", "2.3.1", "compare the token, return NULL if it differs")
def accepts_any_token(bench: Bench) -> Claims:
    """It gives an instance for a wrong token, so a stale description goes unnoticed."""
    if bench.instantiate(token="{00000000-wrong-token}") is not None:  # noqa: S106 (no secret)
        yield bench.library.name, "gave an instance for a token that is not its own"


@error("4.2", "2.3", "read its log and correct the model")
def does_not_run(bench: Bench) -> Claims:
    """It fails in a plain run: start values, the default step, inputs moved a little."""
    try:
        finished(bench)
    except CallFailed as moved:
        bench.results["still"] = str(moved)
        try:
            finished(bench)
        except CallFailed as still:
            yield bench.interface.kind, f"{still}{bench.last_words()}"


@note("", "", "give the inputs min and max")
def fails_when_inputs_move(bench: Bench) -> Claims:
    """It fails when inputs move by a tenth of their size within their range."""
    if "still" in bench.results:
        failed = bench.results["still"]
        yield bench.interface.kind, f"{failed}; inputs are kept at their start values"


@warning("2.1.3", "2.2.4", "return OK when nothing is wrong")
def warns_in_a_plain_run(bench: Bench) -> Claims:
    """Calls of a plain run return Warning."""
    instance = finished(bench).instance
    for name in dict.fromkeys(instance.warned):
        yield f"{bench.binary.prefix}{name}", "returned Warning"


@error("2.1.6", "2.3", "return OK")
def does_not_terminate(bench: Bench) -> Claims:
    """Terminate fails after a plain run."""
    run = finished(bench)
    status = 0 if run.ended else run.instance.status("Terminate")
    yield from bench.failed("Terminate", status)
