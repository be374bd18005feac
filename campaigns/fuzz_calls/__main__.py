"""``python -m campaigns.fuzz_calls --sequences N --seed S``: on every model, FMI 2.0 and 3.0."""

import argparse
import sys
import tempfile
import time
from pathlib import Path

from campaigns.fuzz_calls import Fuzzer, find_compiler
from stickslip import models


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", type=int, default=100_000, help="of each version of FMI")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    names = models.model_names()
    each = -(-options.sequences // len(names))
    with tempfile.TemporaryDirectory() as folder:
        compiler = find_compiler(Path(folder))
        if compiler is None:
            sys.exit("no gcc or clang with working sanitizers for addresses")
        for version in (2, 3):
            for name in names:
                model, place = models.load_model(name), Path(folder, f"{name}{version}")
                fuzzer = Fuzzer.build(compiler, model, version, place)
                begin = time.perf_counter()
                found = fuzzer.run(options.seed, each)
                if found.fault:
                    sys.exit(f"{name}, FMI {version}.0: {found.fault}")
                print(
                    f"{name:20} FMI {version}.0 {each:9} sequences {found.calls:11} calls,"
                    f" {found.unlawful:10} unlawful, {time.perf_counter() - begin:6.1f} s,"
                    f" digest {found.digest}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
