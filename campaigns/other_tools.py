"""``python -m campaigns.other_tools --vdmcheck2 FILE.jar --vdmcheck3 FILE.jar --iec2c FILE``.

Runs the tools that are given on what this project writes: VDMCheck on the FMUs of all models, and
the compiler of matiec on the structured text of every compensator and law and of a rig. A line for
each file has ``ok`` or what the tool says. Status 1 where a tool finds something.
"""

import argparse
import itertools
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from stickslip import models
from stickslip.models.firmware import write_compensator
from stickslip.rigs.ads_rig import CODE
from tests.models.firmware.test_every_compensator import CASES

Job = tuple[Sequence[str | Path], Path]
"""A command and the file that it is about."""


def checked(jar: Path, folder: Path, version: models.FmiVersion) -> Iterator[Job]:
    """Build the FMUs of all models for VDMCheck."""
    for name in models.model_names():
        path = models.build_fmu(name, folder / f"fmi{version}", fmi=version)
        yield ("java", "-jar", jar.absolute(), path), path


def compiled(iec2c: Path, folder: Path) -> Iterator[Job]:
    """Write the structured text of compensators, of feedforwards with every law, and of a rig."""
    compiler = (iec2c.absolute(), "-I", iec2c.absolute().parent / "lib", "-T", folder)
    for case, (model, law, called) in CASES.items():
        for path in write_compensator(folder / case, "st", law=law, model=model, called=called):
            yield (*compiler, path), path
    path = folder / CODE.name
    path.write_text(CODE.read_text(encoding="utf-8"), encoding="utf-8")
    yield (*compiler, path), path


def said(command: Sequence[str | Path], folder: Path) -> str:
    """Return what a tool prints on errors; empty where it ends with 0."""
    done = subprocess.run(
        [str(word) for word in command], cwd=folder, capture_output=True, text=True
    )
    return (done.stdout + done.stderr).strip() or "failed" if done.returncode else ""


def main() -> int:
    """Run the tools; return the exit status."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for name in ("--vdmcheck2", "--vdmcheck3", "--iec2c"):
        options.add_argument(name, type=Path)
    given = options.parse_args()
    found = 0
    with tempfile.TemporaryDirectory(prefix="stickslip-") as name:
        folder = Path(name)
        runs = []
        if given.vdmcheck2:
            runs.append(checked(given.vdmcheck2, folder, 2))
        if given.vdmcheck3:
            runs.append(checked(given.vdmcheck3, folder, 3))
        if given.iec2c:
            runs.append(compiled(given.iec2c, folder))
        for command, path in itertools.chain(*runs):
            text = said(command, folder)
            found += bool(text)
            print(f"{path.relative_to(folder)}: {text or 'ok'}", flush=True)
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main())
