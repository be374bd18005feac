"""Compiles C for any platform with the ``ziglang`` package, into a cache addressed by content.

The ground floor of the house: it knows C files and platforms, nothing of FMI or friction.

    Fault                       what a user can cause; every package's errors are of this kind
    ToolchainError(RuntimeError)
        CompilerMissing     the ``ziglang`` package is not installed
        CompilationFailed   the compiler refused the sources; carries its output
        WrongExports        a library does not offer what it should
        NotALibrary         bytes that are no ELF, PE or Mach-O library (also a ValueError)
"""

from stickslip.fmi.toolchain.binaries import binaries, standard_functions
from stickslip.fmi.toolchain.binary import Interface, interface
from stickslip.fmi.toolchain.cache import cache_directory
from stickslip.fmi.toolchain.child import child_process
from stickslip.fmi.toolchain.compiler import shared_library
from stickslip.fmi.toolchain.errors import (
    CompilationFailed,
    CompilerMissing,
    Fault,
    NotALibrary,
    ToolchainError,
    WrongExports,
)
from stickslip.fmi.toolchain.frame import MAX_MEMBERS, check_frame
from stickslip.fmi.toolchain.interruption import (
    check_interruption,
    held,
    interrupted_by,
    interruptible,
    temporary_folder,
)
from stickslip.fmi.toolchain.lock import is_at, lock
from stickslip.fmi.toolchain.platforms import (
    PLATFORMS,
    Platform,
    host_platform,
)
from stickslip.fmi.toolchain.reading import (
    MOST_TEXT,
    digest,
    open_plain,
    parse_json,
    parse_toml,
    read_whole,
)
from stickslip.fmi.toolchain.streams import open_standard_streams
from stickslip.fmi.toolchain.threads import (
    Threads,
    cancel_all,
    result_of,
    wait_first,
)
from stickslip.fmi.toolchain.universal import universal
from stickslip.fmi.toolchain.whole import (
    refuse_odd,
    sync_folder,
    write_whole,
)

__all__ = [
    "MAX_MEMBERS",
    "MOST_TEXT",
    "PLATFORMS",
    "CompilationFailed",
    "CompilerMissing",
    "Fault",
    "Interface",
    "NotALibrary",
    "Platform",
    "Threads",
    "ToolchainError",
    "WrongExports",
    "binaries",
    "cache_directory",
    "cancel_all",
    "check_frame",
    "check_interruption",
    "child_process",
    "digest",
    "held",
    "host_platform",
    "interface",
    "interrupted_by",
    "interruptible",
    "is_at",
    "lock",
    "open_plain",
    "open_standard_streams",
    "parse_json",
    "parse_toml",
    "read_whole",
    "refuse_odd",
    "result_of",
    "shared_library",
    "standard_functions",
    "sync_folder",
    "temporary_folder",
    "universal",
    "wait_first",
    "write_whole",
]
