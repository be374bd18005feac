"""Groups 14, 15, 16, 20 and 29: binaries that do not load, refuse, attack, run out, reach out."""

from pathlib import Path

from stickslip import cosim
from tests.corpus.hostile import fmus
from tests.corpus.hostile.case import Case

_RUN = "simulate h.fmu --isolate --memory 200 --timeout"


def _attack(
    name: str, behaviour: str, about: str, says: str, *, version: int = 2, group: int = 16
) -> Case:
    hangs = any(word in behaviour for word in ("hang", "deaf", "flood"))
    files = {"h.fmu": lambda path: fmus.write(path, behaviour, version=version)}
    return Case(group, name, about, says, f"{_RUN} {0.8 if hangs else 60}", files)


def _pair(name: str, about: str, behaviour: str, says: str, flags: str = "") -> Case:
    """Return a case of a package with two components of one FMU."""

    def package(path: Path) -> None:
        system = cosim.System("pair")
        for component in ("one", "two"):
            system.add(component, path.with_name("h.fmu"))
        system.connect("one.y", "two.u")
        cosim.write_ssp(system, path, cosim.DefaultExperiment(0.0, 0.1, 0.01))

    files = {"h.fmu": lambda path: fmus.write(path, behaviour, flags=flags), "pair.ssp": package}
    return Case(20, name, about, says, _RUN.replace("h.fmu", "pair.ssp") + " 60", files)


def _lying(*changes: tuple[bytes, bytes]) -> bytes:
    """Return the library with some bytes replaced by as many others."""
    content = fmus.library()
    for old, new in changes:
        if old not in content or len(old) != len(new):
            raise ValueError(f"{old!r} cannot become {new!r}")
        content = content.replace(old, new)
    return content


def _other_machine(content: bytes) -> bytes:
    """Return a library of ELF for a processor that nobody has."""
    return content[:18] + (94).to_bytes(2, "little") + content[20:]


def _binaries(name: str, about: str, says: str, **binaries: object) -> Case:
    """Return a case of an FMU with other binaries than the usual one."""

    def write(path: Path) -> None:
        made = {
            place: content() if callable(content) else content
            for place, content in binaries.items()
        }
        fmus.write(path, binaries=made)

    return Case(14, name, about, says, f"{_RUN} 60", {"h.fmu": write})


_HERE = fmus.place()

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


_NOT_LOADING = [
    _binaries("no-binaries", "no binary at all", r".*h\.fmu: no binary for this machine"),
    _binaries("other-platform", "binaries for other platforms only", r".*no binary for this machine: expected .*, the FMU has plan9", **{"binaries/plan9/hostile.so": fmus.library}),
    _binaries("no-name-fits", "several libraries, none called like the modelIdentifier", r".*no binary for this machine: expected .*hostile", **{fmus.place(name="one"): fmus.library, fmus.place(name="other"): fmus.library}),
    _binaries("binary-is-folder", "a folder in the place of the library", r".*(no binary for this machine|cannot be loaded)", **{f"{_HERE}/readme.txt": b"nothing"}),
    _binaries("text", "text as a library", r".*cannot be loaded", **{_HERE: b"#!/bin/sh\n"}),
    _binaries("cut-short", "half a library", r".*(cannot be loaded|loading its binary died)", **{_HERE: lambda: fmus.library()[: len(fmus.library()) // 2]}),
    _binaries("wrong-architecture", "a library for another processor", r".*cannot be loaded", **{_HERE: lambda: _other_machine(fmus.library())}),
    _binaries("missing-function", "a library without fmi2DoStep", r".*has no function fmi2DoStep", **{_HERE: lambda: _lying((b"\0fmi2DoStep\0", b"\0fmi2DoStup\0"))}),
    _binaries("missing-library", "needs a library that is not there", r".*cannot be loaded: libq.*; install this library \(the package libq6 in Debian", **{_HERE: lambda: _lying((b"\0libc.so.6\0", b"\0libq.so.6\0"))}),
]  # fmt: skip


_REFUSING = [
    Case(15, "token-refused", "the token of the description is not that of the binary", r"hostile: h\.fmu cannot be instantiated; the FMU says: wrong token", f"{_RUN} 60", {"h.fmu": lambda path: fmus.write(path, token="other")}),  # noqa: S106
    _attack("null", "Instantiate null", "no instance, and not a word", r"hostile: h\.fmu cannot be instantiated", group=15),
    _attack("null-with-reason", "Instantiate say_null", "no instance, for a reason", r"hostile: h\.fmu cannot be instantiated; the FMU says: no licence", version=3, group=15),
    _attack("garbage-instance", "Instantiate garbage", "an address that is no instance", r"hostile \(h\.fmu\): fmi2SetReal died of SIGSEGV", group=15),
]  # fmt: skip

_DIES = r"hostile \(h\.fmu\): "

_ATTACKING = [
    _attack("constructor-crash", "load segv", "crashes when it is loaded", r"h\.fmu: loading its binary died of SIGSEGV"),
    _attack("constructor-exit", "load exit0", "ends the process with success when it is loaded", r"h\.fmu: loading its binary ended its process with status 0", version=3),
    _attack("constructor-hang", "load hang", "never comes back from being loaded", r"h\.fmu: loading its binary (did not return|was going on when)"),
    _attack("initialise-hang", "ExitInitializationMode hang", "never comes back from Initialization Mode", _DIES + "fmi2ExitInitializationMode did not return within 0.8 s during initialisation"),
    _attack("step-crash", "DoStep segv 4", "crashes in a step", _DIES + r"fmi2DoStep died of SIGSEGV at t = 0\.03 s"),
    _attack("step-abort", "DoStep last_words 4", "fails an assertion in a step", _DIES + r"fmi3DoStep died of SIGABRT at t = 0\.03 s; it printed: assertion failed: x > 0", version=3),
    _attack("step-exit", "DoStep exit0 4", "ends the process with success in a step", _DIES + r"fmi2DoStep ended its process with status 0 at t = 0\.03 s"),
    _attack("stack-overflow", "DoStep overflow", "calls itself without end", _DIES + "fmi2DoStep died of SIGSEGV"),
    _attack("step-hang", "DoStep hang 4", "never comes back from a step", _DIES + r"fmi3DoStep did not return within 0.8 s at t = 0\.03 s", version=3),
    _attack("suspended", "DoStep deaf", "ignores all signals and suspends its process", _DIES + "fmi2DoStep did not return within 0.8 s"),
    _attack("setter-exit", "SetReal exit0 6", "ends the process when an input is set", _DIES + r"fmi3SetFloat64 ended its process with status 0 at t = 0\.0\d s", version=3),
    _attack("destructor-crash", "unload segv", "crashes when it is unloaded", r"h\.fmu: unloading its binary died of SIGSEGV"),
    _attack("memory", "DoStep leak", "takes all memory there is", _DIES + r"fmi2DoStep died of SIG(SEGV|KILL)"),
    _attack("flood", "DoStep flood", "prints without end", _DIES + "fmi2DoStep did not return within 0.8 s"),
    _attack("log-flood", "DoStep flood_log", "logs without end", _DIES + "fmi3DoStep did not return within 0.8 s", version=3),
    _attack("fork-crash", "DoStep daemon_segv", "leaves a process behind and crashes", _DIES + "fmi2DoStep died of SIGSEGV"),
    _attack("closed-files", "DoStep close", "closes all files of its process", _DIES + "fmi2[A-Za-z]+ or a call before it closed files"),
    _attack("foreign-files", "DoStep scribble", "writes into all files of its process", _DIES + "fmi3[A-Za-z0-9]+ or a call before it wrote into files", version=3),
    _attack("format", "DoStep fail_format", "fails with a message that would write where it must not", r"hostile: fmi2DoStep returned error .*; the FMU says: 50 %n of it failed %s"),
]  # fmt: skip

_NUMBERED = [
    _pair("once-per-process", "can be instantiated once per process, and is wanted twice", "", r"two: .*\.fmu can be instantiated only once per process", 'canBeInstantiatedOnlyOncePerProcess="true"'),
    _pair("second-refused", "gives one instance only, and does not declare it", "Instantiate say_null 2", r"two: .*\.fmu cannot be instantiated; the FMU says: no licence"),
    _pair("second-crashes", "crashes on the second instance", "Instantiate segv 2", r"two \(.*\.fmu\): fmi2Instantiate died of SIGSEGV"),
    _pair("same-instance", "gives the same instance to both", "Instantiate same 2", r"two: .*\.fmu gives an instance that it has given before"),
]  # fmt: skip

_REACHING = [
    _reaches("home", "read_home", "reads the home folder", "tried to read .*, which the sandbox denies"),
    _reaches("kill-parent", "kill_parent", "kills the process that started it", r"tried to send a signal to process \d+, which the sandbox denies", harms=True),
    _reaches("share", "share", "takes all memory as shared mappings", "took more than the 100 MB it may"),
]  # fmt: skip

CASES = [*_NOT_LOADING, *_REFUSING, *_ATTACKING, *_NUMBERED, *_REACHING]
