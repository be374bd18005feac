"""Random sequences of FMI calls on our FMUs, in C under the sanitizers of a system compiler."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from stickslip.models import Model
from stickslip.models.export.sources import (
    START,
    FmiVersion,
    c_files,
    compiled,
    fmi_headers,
    start_source,
)

SANITIZE = (
    "-fsanitize=address,undefined,float-cast-overflow",
    "-fno-sanitize-recover=all",
    "-g1",  # lines, no variables: half the time of the compiler
    "-Og",
)


def find_compiler(folder: Path) -> str | None:
    """Return a system compiler whose sanitizers work; ziglang brings none for addresses."""
    source, program = folder / "empty.c", folder / "empty"
    source.write_text("int main(void) { return 0; }\n")
    for name in filter(shutil.which, ("gcc", "clang", "cc")):
        command = [name, *SANITIZE, str(source), "-o", str(program)]
        if all(
            subprocess.run(c, capture_output=True).returncode == 0 for c in (command, [program])
        ):
            return name
    return None


@dataclass(frozen=True)
class Outcome:
    """What sequences of calls came to; ``fault`` is empty when all laws held."""

    calls: int
    unlawful: int
    digest: str
    fault: str


@dataclass(frozen=True)
class Fuzzer:
    """A program that calls one model by one version of FMI."""

    program: Path

    @classmethod
    def build(cls, compiler: str, model: Model, version: FmiVersion, folder: Path) -> Fuzzer:
        files = c_files(model, version) | {
            START: start_source("token", [v.start for v in model.variables])
        }
        files |= {f"system/{name}": text for name, text in fmi_headers(version).items()}
        files |= {file.name: file.read_text() for file in Path(__file__).parent.glob("*.[ch]")}
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text)
        command = [compiler, *SANITIZE, f"-DFMI={version}", "-std=gnu11", "-ffp-contract=off"]
        command += ["-I.", "-isystem", "system", *compiled(files), "-lm", "-o", "sequences"]
        subprocess.run(command, cwd=folder, check=True)
        return cls(folder / "sequences")

    def run(self, first: int, count: int) -> Outcome:
        """Run the sequences with the seeds first .. first + count - 1."""
        done = subprocess.run(
            [self.program, str(first), str(count)],
            capture_output=True,
            text=True,
            env=os.environ | {"ASAN_OPTIONS": "detect_leaks=1:allocator_may_return_null=1"},
        )
        if done.returncode:
            return Outcome(0, 0, "", done.stderr or f"ended with status {done.returncode}")
        calls, unlawful, digest = done.stdout.split()
        return Outcome(int(calls), int(unlawful), digest, "")
