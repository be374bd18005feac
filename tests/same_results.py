"""``python -m tests.same_results COMMIT COMMIT``: do two commits compute the same results?

Each commit is exported to a temporary folder, installed with pip beside this interpreter's own
packages, and runs `COMMANDS`. What ``git diff`` finds in their CSV tables and in ``learned.json``
is printed, and the exit status is then 1.
"""

import argparse
import hashlib
import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

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
    m, b, F_s, F_c, v_s, sigma_0, sigma_1 = 5.5, 7.0, 9.0, 6.0, 5e-4, 4e5, 4.5e3
    K_p, K_i, T_s, substeps, encoder = 1681.0, 137167.0, 5e-4, 10, 4e-7
    h = T_s / substeps
    noise = random.Random(seed)  # noqa: S311 (no secret)
    x = v = z = integral = x_last = v_meas = force = 0.0
    with path.open("w", encoding="utf-8") as file:
        file.write("t [s],v_cmd [m/s],x_enc [m],F_motor [N]\n")
        for step in range(40_001):
            t = step * T_s
            x_enc = round((x + noise.gauss(0.0, 5e-8)) / encoder) * encoder
            v_meas += 0.5 * ((x_enc - x_last) / T_s - v_meas)
            x_last = x_enc
            command = commanded_velocity(t)
            integral += K_i * T_s * (command - v_meas)
            force = K_p * (command - v_meas) + integral
            file.write(f"{t:.4f},{command:.9g},{x_enc:.9g},{force:.9g}\n")
            for _ in range(substeps):
                g = F_c + (F_s - F_c) * math.exp(-((v / v_s) ** 2))
                rate = sigma_0 * abs(v) / g
                held = v / rate if rate else 0.0
                decay = -math.expm1(-rate * h)
                dz = (held - z) * decay if rate else 0.0
                z += dz
                v += h / m * (force - sigma_0 * z - sigma_1 * dz / h - b * v)
                x += h * v


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
