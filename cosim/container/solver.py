"""CVode for the components by Model Exchange: the libraries that FMPy brings along."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from stickslip.cosim.errors import FmuError
from stickslip.fmi.toolchain import Platform

# Those of macOS are for both processors.
_FOLDERS = {
    "x86_64-linux": "x86_64-linux",
    "x86_64-windows": "x86_64-windows",
    "x86_64-darwin": "aarch64-darwin",
    "aarch64-darwin": "aarch64-darwin",
}
_LICENCE = "licenses/LICENSE.txt"  # FMPy's own and that of SUNDIALS, of which CVode is a part


def solver_members(targets: Iterable[Platform]) -> dict[str, bytes]:
    """Return the files, by path in the container.

    Raises
    ------
    FmuError
        When there is no solver for a platform.
    """
    import fmpy  # large, and not needed before

    members = {}
    for target in targets:
        folder = Path(fmpy.__file__).parent / "sundials" / _FOLDERS.get(target.tuple, "-")
        if not folder.is_dir():
            raise FmuError(
                f"Model Exchange needs the solver CVode, which FMPy has for {', '.join(_FOLDERS)},"
                f" not for {target.tuple}; use Co-Simulation, or leave the platform out"
            )
        for file in sorted(folder.iterdir()):
            members[f"resources/cvode/{target.tuple}/{file.name}"] = file.read_bytes()
    licence = metadata.distribution("fmpy").read_text(_LICENCE)
    if licence is None:
        raise FmuError(f"FMPy is installed without {_LICENCE}; install it again")
    members["documentation/licenses/sundials.txt"] = licence.encode()
    return members
