"""Start values written into libraries: what was compiled with them, and macOS' hashes."""

import hashlib
import struct
import zipfile

import pytest

from stickslip import models
from stickslip.fmi.toolchain import PLATFORMS, ToolchainError, patched

START_VALUES = {"A[1,1]": 4.25, "D": 1e-300}


def library_of(path):
    with zipfile.ZipFile(path) as archive:
        [name] = [one for one in archive.namelist() if one.startswith("binaries/")]
        return archive.read(name)


def pages(library):
    """Yield the hash of each page, as signed and as it is: the code directory of a library."""
    place = 32
    for _ in range(struct.unpack_from("<I", library, 16)[0]):
        command, size, at = struct.unpack_from("<III", library, place)
        if command == 0x1D:
            break
        place += size
    else:
        return
    count = struct.unpack_from(">I", library, at + 8)[0]
    offsets = [struct.unpack_from(">I", library, at + 16 + 8 * k)[0] for k in range(count)]
    [code] = [
        at + one for one in offsets if library[at + one : at + one + 4] == b"\xfa\xde\x0c\x02"
    ]
    hashes, _, _, number, limit = struct.unpack_from(">5I", library, code + 16)
    page = 1 << library[code + 39]
    for k in range(number):
        signed = library[code + hashes + 32 * k : code + hashes + 32 * (k + 1)]
        yield signed, hashlib.sha256(library[k * page : min(limit, (k + 1) * page)]).digest()


@pytest.mark.parametrize(
    "platform", [p for p in PLATFORMS.values() if p.suffix == ".dylib"], ids=str
)
def test_the_signature_of_a_library_of_macos_holds(platform, tmp_path):
    fmu = models.build_fmu(
        "nominal_loop", tmp_path, fmi=3, platforms=[platform], start=START_VALUES
    )
    library = library_of(fmu)
    assert struct.pack("<d", 4.25) in library
    found = list(pages(library))
    assert found or "aarch64" not in platform.target
    assert all(signed == content for signed, content in found)


def test_a_library_without_the_place_is_refused():
    for library in (b"", b"here here"):
        with pytest.raises(ToolchainError, match=r"contains b'here' \d times"):
            patched(library, b"here", b"1")
