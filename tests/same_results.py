"""``python -m tests.same_results COMMIT COMMIT``: do two commits compute the same results?

Each commit is exported to a temporary folder, installed with pip beside this interpreter's own
packages, and runs `COMMANDS`. What ``git diff`` finds in their CSV tables and in ``learned.json``
is printed, and the exit status is then 1.
"""

import argparse
import hashlib
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from campaigns.sound_drives import simulator

ROOT = Path(__file__).parents[1]
COMMANDS = {
    "drive": "reproduce",
    "record": "reproduce --mode record",
    "learn": "learn --log log.csv --column force=F_motor --controller PI"
    " --gain K_p=1681 K_i=137167 tau_f=5e-4 --encoder-step 4e-7",  # by the output error
    "learn_inverse": "learn --log log.csv --column force=F_motor",  # by the inverse model
}
PUBLISHED = {"published": "reproduce --as-published"}


def simulate_log(path: Path, seed: int = 0) -> None:
    """Write 20 s of a stage with LuGre friction, PI controller and encoder; no stickslip in it."""
    drive = {"m": 5.5, "b": 7.0, "F_s": 9.0, "F_c": 6.0, "v_s": 5e-4, "delta": 2.0, "sigma_0": 4e5}
    drive |= {"sigma_1": 4.5e3, "K_p": 1681.0, "K_i": 137167.0, "tau_f": 5e-4, "T_s": 5e-4}
    t = drive["T_s"] * np.arange(40_001)
    v_cmd = np.array([*map(commanded_velocity, t)])
    found = simulator.run("lugre", drive | {"encoder": 4e-7}, v_cmd, noise=(0.125, 0.0), seed=seed)
    rows = np.transpose([t, v_cmd, found["encoder"], found["commanded"]])
    head = "t [s],v_cmd [m/s],x_enc [m],F_motor [N]"
    np.savetxt(path, rows, "%.9g", ",", header=head, comments="")


def commanded_velocity(t: float) -> float:
    """Return small moves, slow reversals, constant speeds, quick ramps and a sine sweep, in m/s."""
    if t < 3.0:
        return 2e-6 * (1 + t) * 40.0 * math.cos(40.0 * t)
    if t < 8.0:
        return 1e-3 * math.sin(2 * math.pi * (t - 3.0))
    if t < 11.0:
        return (5e-3, -5e-3, 2e-2, -2e-2, 4e-2, -4e-2)[int(2 * (t - 8.0))]
    if t < 13.0:
        return 4e-2 * (2 * abs(2 * ((2 * (t - 11.0)) % 1.0) - 1) - 1)
    return 4e-2 * math.sin(2 * math.pi * (t - 13.0) * (1 + 0.4 * (t - 13.0)))


def install(commit: str, folder: Path) -> dict[str, str]:
    """Install a commit into a folder; return the environment in which Python imports it."""
    tree, packages = folder / "tree", folder / "packages"
    tree.mkdir()
    archive = subprocess.Popen(
        ["git", "archive", commit],  # noqa: S607
        cwd=ROOT,
        stdout=subprocess.PIPE,
    )
    subprocess.run(["tar", "-x", "-C", tree], stdin=archive.stdout, check=True)  # noqa: S607
    if archive.wait():
        sys.exit(f"same_results: git archive {commit} failed")
    quiet = ["--quiet", "--disable-pip-version-check", "--no-deps", "--target", str(packages)]
    subprocess.run([sys.executable, "-m", "pip", "install", *quiet, str(tree)], check=True)
    environment = os.environ | {"PYTHONPATH": str(packages)}
    where = "import stickslip; print(stickslip.__file__)"
    found = subprocess.run(
        [sys.executable, "-P", "-c", where],
        cwd=folder, env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    if not Path(found.stdout.strip()).is_relative_to(packages):
        sys.exit(f"same_results: stickslip is imported from {found.stdout.strip()}, not {packages}")
    return environment


def results(commit: str, commands: dict[str, str], keep: Path) -> Path:
    """Return the folder of a commit's tables, computed if ``keep`` does not hold it."""
    sha = subprocess.run(
        ["git", "rev-parse", "--verify", f"{commit}^{{commit}}"],  # noqa: S607
        cwd=ROOT, check=True, capture_output=True, text=True,
    ).stdout.strip()  # fmt: skip
    keep.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=keep, prefix="unfinished-") as name:
        folder = Path(name)
        simulate_log(folder / "log.csv")
        inputs = repr(commands).encode() + (folder / "log.csv").read_bytes()
        whole = keep / f"{sha[:12]}-{hashlib.sha256(inputs).hexdigest()[:8]}"
        if whole.is_dir():
            return whole
        environment = install(sha, folder)
        for out, command in commands.items():
            print(f"{sha[:12]}: stickslip {command}", file=sys.stderr, flush=True)
            arguments = [*command.split(), "--out", f"results/{out}"]
            done = subprocess.run(
                [sys.executable, "-P", "-m", "stickslip", *arguments],
                cwd=folder, env=environment, stdout=subprocess.DEVNULL,
            )  # fmt: skip
            if done.returncode:
                sys.exit(f"same_results: {commit}: stickslip {command}: status {done.returncode}")
        for path in (folder / "results").rglob("*.*"):
            if path.is_file() and path.suffix != ".csv" and path.name != "learned.json":
                path.unlink()
        (folder / "results").replace(whole)
    return whole


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("commits", nargs=2, metavar="COMMIT")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="of results, to use again")
    parser.add_argument("--published", action="store_true", help="also run --as-published")
    options = parser.parse_args()
    commands = COMMANDS | (PUBLISHED if options.published else {})
    with tempfile.TemporaryDirectory() as temporary:
        keep = (options.keep or Path(temporary)).resolve()
        folders = [results(commit, commands, keep) for commit in options.commits]
        sys.exit(subprocess.run(["git", "diff", "--no-index", *folders], check=False).returncode)  # noqa: S607


if __name__ == "__main__":
    main()
