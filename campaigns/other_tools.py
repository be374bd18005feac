"""``python -m campaigns.other_tools --vdmcheck2 FILE.jar --vdmcheck3 FILE.jar --iec2c FILE``.

Runs the tools that are given on what this project writes: VDMCheck on the FMUs of all models, and
the compiler of matiec on the structured text of every compensator and law. A line for each file has
``ok`` or what the tool says. Status 1 where a tool finds something.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from stickslip import models
from stickslip.models.firmware import write_compensator
from tests.models.firmware.test_every_compensator import CASES

Job = tuple[list[str | Path], Path]
"""A command and the file that it is about."""


def jobs(given: argparse.Namespace, folder: Path) -> Iterator[Job]:
    """Yield the FMUs of all models for VDMCheck, and structured text for matiec.

    The text is that of compensators, and of feedforwards with every law.
    """
    for version, jar in ((2, given.vdmcheck2), (3, given.vdmcheck3)):
        for name in models.model_names() if jar else ():
            path = models.build_fmu(name, folder / f"fmi{version}", fmi=version)
            yield ["java", "-jar", jar.absolute(), path], path
    if given.iec2c:
        compiler = [iec2c := given.iec2c.absolute(), "-I", iec2c.parent / "lib", "-T", folder]
        for case, (model, law, called) in CASES.items():
            for path in write_compensator(folder / case, "st", law=law, model=model, called=called):
                yield [*compiler, path], path


def main() -> int:
    """Run the tools; return the exit status."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for name in ("--vdmcheck2", "--vdmcheck3", "--iec2c"):
        options.add_argument(name, type=Path)
    found = 0
    with tempfile.TemporaryDirectory(prefix="stickslip-") as name:
        folder = Path(name)
        for command, path in jobs(options.parse_args(), folder):
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            text = (done.stdout + done.stderr).strip() or "failed" if done.returncode else "ok"
            found += done.returncode != 0
            print(f"{path.relative_to(folder)}: {text}", flush=True)
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main())
