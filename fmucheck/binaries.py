"""Rules about binaries/: a library for each platform, with what it must export; none is loaded."""

import posixpath
import re
from collections.abc import Iterator
from functools import cache

from stickslip.fmi.binary import Library, NotALibrary, read_library
from stickslip.fmi.standard import standard_files
from stickslip.fmi.toolchain import standard_functions
from stickslip.fmucheck.description.model import Fmu, listed
from stickslip.fmucheck.rules import Claims, error, note, warning

# What only one interface must have; all others that the headers declare, each must.
_ONLY = {
    2: {
        "ModelExchange": """
            EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep
            SetTime SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates
            GetNominalsOfContinuousStates
        """,
        "CoSimulation": """
            SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus
            GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus
        """,
    },
    3: {
        "ModelExchange": """
            InstantiateModelExchange EnterContinuousTimeMode CompletedIntegratorStep SetTime
            SetContinuousStates GetContinuousStateDerivatives GetEventIndicators
            GetContinuousStates GetNominalsOfContinuousStates GetNumberOfEventIndicators
            GetNumberOfContinuousStates
        """,
        "CoSimulation": "InstantiateCoSimulation EnterStepMode GetOutputDerivatives DoStep",
        "ScheduledExecution": "InstantiateScheduledExecution ActivateModelPartition",
    },
}


@cache
def required(version: int, interface: str) -> list[str]:
    """Return the names of all functions of an interface, those of optional abilities included."""
    header = standard_files("c-code") / f"fmi{version}Functions.h"
    only = {kind: set(words.split()) for kind, words in _ONLY[version].items()}
    foreign = set().union(*only.values()) - only.get(interface, set())
    every = standard_functions(header.read_text("utf-8"))
    return [name for name in every if name[4:] not in foreign]


_FMI2 = {
    f"{short}{bits}": f"{processor}-{system}"
    for short, system in (("win", "windows"), ("linux", "linux"), ("darwin", "darwin"))
    for bits, processor in ((32, "x86"), (64, "x86_64"))
}
_TUPLE = re.compile(r"(aarch32|aarch64|riscv32|riscv64|x86|x86_64|ppc32|ppc64)-(\w+)(-\w+)?")
_SUFFIXES = {"windows": ".dll", "linux": ".so", "darwin": ".dylib"}
# What every machine of a system has: the C library, the loader, the system itself.
_AT_HOME = re.compile(
    r"lib(c|m|dl|rt|pthread|util|gcc_s|stdc\+\+|c\+\+|unwind)\.so.*|ld-linux.*|linux-vdso.*"
    r"|(kernel32|kernelbase|ntdll|user32|gdi32|advapi32|shell32|shlwapi|ws2_32|ole32|oleaut32"
    r"|msvcrt|ucrtbase|bcrypt|rpcrt4|version|winmm|psapi|crypt32|secur32|api-ms-win-.*)\.dll"
    r"|/usr/lib/.*|/System/Library/.*",
    re.IGNORECASE,
)


def target(folder: str, version: int) -> str | None:
    """Return the tuple that a folder below binaries/ stands for, ``None`` for an unknown one."""
    if version == 2 and folder in _FMI2:
        return _FMI2[folder]
    found = _TUPLE.fullmatch(folder)
    return f"{found[1]}-{found[2]}" if found and found[2] in _SUFFIXES else None


def folders(fmu: Fmu) -> list[str]:
    """Return the names of the folders below binaries/."""
    return list(dict.fromkeys(n.split("/")[1] for n in fmu.below("binaries/") if n.count("/") > 1))


def binaries(fmu: Fmu) -> Iterator[tuple[str, str, str]]:
    """Yield platform tuple, modelIdentifier and expected path of every binary there should be."""
    for folder in folders(fmu):
        tuple_ = target(folder, fmu.description.version)
        for identifier in fmu.identifiers if tuple_ else ():
            suffix = _SUFFIXES[str(tuple_).partition("-")[2]]
            yield str(tuple_), identifier, f"binaries/{folder}/{identifier}{suffix}"


def _libraries(fmu: Fmu) -> Iterator[tuple[str, str, str, Library]]:
    for tuple_, identifier, name in binaries(fmu):
        if name in fmu.members:
            try:
                library = read_library(fmu.bytes(name))
            except NotALibrary:  # the subject of a rule of its own
                continue
            yield tuple_, identifier, name, library


@error("2.3", "2.5", "add a binary or the sources")
def no_implementation(fmu: Fmu) -> Claims:
    """There are neither binaries nor sources."""
    if not folders(fmu) and not fmu.below("sources/"):
        yield "binaries", "the FMU has neither binaries nor sources"


@error("2.3", "2.5.1.4", "name it modelIdentifier.dll, .so or .dylib")
def binary_missing(fmu: Fmu) -> Claims:
    """A platform's folder has no binary named after the modelIdentifier."""
    for _, _, name in binaries(fmu):
        if name not in fmu.members:
            there = [posixpath.basename(n) for n in fmu.below(posixpath.dirname(name) + "/")]
            yield name, f"is not in the FMU; there is {listed(there)}"


@note("2.3", "2.5.1.4", "use a name of the standard")
def unknown_platform(fmu: Fmu) -> Claims:
    """A folder below binaries/ has a name that the standard does not define."""
    for folder in folders(fmu):
        if target(folder, fmu.description.version) is None:
            yield f"binaries/{folder}", "is not a platform of the standard; it was not checked"


@error("2.3", "2.5.1.4", "build it as a shared library")
def not_a_library(fmu: Fmu) -> Claims:
    """A binary is not a shared library."""
    for _, _, name in binaries(fmu):
        if name in fmu.members:
            try:
                read_library(fmu.bytes(name))
            except NotALibrary as fault:
                yield name, str(fault)


@error("2.3", "2.5.1.4", "put it into the folder of its platform")
def wrong_architecture(fmu: Fmu) -> Claims:
    """A binary is built for another system or processor than that of its folder."""
    for tuple_, _, name, library in _libraries(fmu):
        # FMI 2.0 has one folder for macOS, older than its second processor.
        mac = fmu.description.version == 2 and tuple_.endswith("-darwin")
        fits = any(t == tuple_ or (mac and t.endswith("-darwin")) for t in library.targets)
        if not fits:
            yield name, f"is built for {listed(sorted(library.targets))}; expected {tuple_}"


@error("2.3", "2.5", "export them; optional ones may just fail")
def missing_function(fmu: Fmu) -> Claims:
    """A binary does not export a function that a declared interface must have."""
    version = fmu.description.version
    for _, identifier, name, library in _libraries(fmu):
        kinds = [i.kind for i in fmu.description.interfaces if i.identifier == identifier]
        wanted = dict.fromkeys(f for kind in kinds for f in required(version, kind))
        missing = [function for function in wanted if function not in library.exports]
        if missing:
            yield name, f"does not export {listed(missing)}"


@warning("2.3", "2.5.1.4", "link it statically or pack it beside")
def foreign_dependency(fmu: Fmu) -> Claims:
    """A binary needs a library that is neither part of the system nor packed beside it."""
    for _, _, name, library in _libraries(fmu):
        there = fmu.below(posixpath.dirname(name) + "/")
        beside = {posixpath.basename(n).casefold() for n in there}
        for needed in library.needs:
            at_home = _AT_HOME.fullmatch(needed)
            if not at_home and posixpath.basename(needed).casefold() not in beside:
                yield name, f"needs {needed}"


@error("", "", "sign it, if only ad hoc: codesign -s -")
def unsigned_for_arm_mac(fmu: Fmu) -> Claims:
    """A binary for macOS on arm64 has no signature, so the system will not load it."""
    for _, _, name, library in _libraries(fmu):
        if library.unsigned:
            yield name, "has no code signature"
