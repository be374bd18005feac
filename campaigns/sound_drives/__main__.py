"""What ``stickslip learn`` hands over on random sound drives, evaluated on the true drives.

    python -m campaigns.sound_drives --drives 40 --seed 1 --out DIR [LEARN-OPTIONS ...]
    python -m campaigns.sound_drives --drives 40 --seed 1 --logs-only DIR
    python -m campaigns.sound_drives --evaluate DRIVE.json LEARNED_DIR [TUNED_DIR]

A row of rows.csv is a drive; drives that it has are not learned again. A ratio is the RMS of the
true velocity minus that of the loop without friction, with what was written over without it.
With a folder of ``stickslip tune``, errors against the command are compared with those before it.
Options that are not of this command go to ``stickslip learn``.
"""

import argparse
import contextlib
import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import pandas as pd

from campaigns.sound_drives.drives import AXES, STICKSLIP, Drive, draw, write_log
from campaigns.sound_drives.evaluation import MOTIONS, evaluated, tuned_ratios


def main() -> None:
    """Draw, record, learn, evaluate, and print a row for each drive."""
    parser = argparse.ArgumentParser(
        prog="python -m campaigns.sound_drives",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--drives", type=int, default=40, metavar="N")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--axis", choices=AXES, default=AXES[0], help="which force of position")
    parser.add_argument("--out", type=Path, default=Path("sound_drives"), metavar="DIR")
    several = "a log for each kind of motion, learned together"
    parser.add_argument("--several", action="store_true", help=several)
    parser.add_argument("--workers", type=int, default=1, help="drives at a time")
    parser.add_argument("--json", action="store_true", help="print rows as JSON")
    parser.add_argument("--logs-only", type=Path, metavar="DIR", help="write logs and truth")
    parser.add_argument("--evaluate", nargs="+", type=Path, metavar="PATH")
    options, of_learn = parser.parse_known_args()
    if options.evaluate:
        drive, *folders = options.evaluate
        evaluate = tuned_ratios if len(folders) > 1 else evaluated
        show(evaluate(Drive.read(drive), *folders), as_json=options.json)
        return
    folder = options.logs_only or options.out
    folder.mkdir(parents=True, exist_ok=True)
    numbers = range(options.first, options.first + options.drives)
    if options.logs_only:
        for number in numbers:
            drive = recorded(options, number, folder)
            print("stickslip", *learn_command(drive, folder), flush=True)
        return
    rows = list(measured(options, numbers, of_learn))
    print(summary(pd.DataFrame(rows)))


def recorded(options: argparse.Namespace, number: int, folder: Path) -> Drive:
    """Return a drive whose log is in a folder."""
    drive = draw(options.seed, number, options.axis)
    path = folder / f"{drive.name}.json"
    if path.exists():
        return Drive.read(path)
    return write_log(drive, folder, several=options.several)


def learn_command(drive: Drive, folder: Path) -> list[str]:
    """Return the arguments of ``stickslip`` that learn the log of a drive."""
    several, out = folder / drive.name, folder / f"{drive.name}.learned"
    log = several if several.is_dir() else folder / f"{drive.name}.csv"
    return ["learn", str(log), *drive.learn, "--out", str(out)]


def measured(
    options: argparse.Namespace, numbers: range, of_learn: list[str]
) -> Iterator[dict[str, Any]]:
    """Yield the rows of all drives; those that are new are printed and written at once."""
    path = options.out / "rows.jsonl"
    rows = [json.loads(line) for line in path.open()] if path.exists() else []
    yield from rows
    done = {row["drive"] for row in rows}
    waiting = [number for number in numbers if f"drive_{number:02}" not in done]
    with ThreadPoolExecutor(options.workers) as pool:
        jobs = [pool.submit(learn_one, options, number, of_learn) for number in waiting]
        for job in as_completed(jobs):
            row = job.result()
            rows.append(row)
            with path.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(row) + "\n")
            pd.DataFrame(rows).sort_values("drive").to_csv(options.out / "rows.csv", index=False)
            show(row, as_json=options.json)
            yield row


def learn_one(options: argparse.Namespace, number: int, of_learn: list[str]) -> dict[str, Any]:
    """Return the row of one drive."""
    drive = recorded(options, number, options.out)
    command = learn_command(drive, options.out)
    shutil.rmtree(command[-1], ignore_errors=True)
    messages = options.out / f"{drive.name}.err"
    with messages.open("w") as stream:
        process = subprocess.Popen(
            [STICKSLIP, *command, *of_learn], stdout=subprocess.DEVNULL, stderr=stream
        )
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    row = evaluated(drive, Path(command[-1]), messages.read_text())
    shutil.rmtree(options.out / drive.name, ignore_errors=True)
    with contextlib.suppress(FileNotFoundError):
        (options.out / f"{drive.name}.csv").unlink()
    seconds, memory = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0
    return row | {"status": process.returncode, "cpu": round(seconds, 1), "MB": round(memory)}


def show(row: dict[str, Any], *, as_json: bool) -> None:
    """Print a row."""
    if as_json:
        print(json.dumps(row), flush=True)
        return
    print("  ".join(f"{k} {v}" for k, v in row.items() if v != ""), flush=True)


def summary(rows: pd.DataFrame) -> str:
    """Return what the rows say together, a line each."""
    written = rows[rows["written"] != ""]
    lines = [f"drives {len(rows)}, written {len(written)} ({len(written) / len(rows):.0%})"]
    if len(written):
        mean, worst = written["mean"], written[["worst", "worst_0.7", "worst_1.3"]].max()
        lines += [
            f"geometric mean: median {mean.median():.3f}, 90 % quantile {mean.quantile(0.9):.3f}",
            "worst ratio: " + ", ".join(f"{name} {value:.3f}" for name, value in worst.items()),
        ]
        if "held" in written:
            held = written["held"].dropna()
            count = len(MOTIONS) * len(held)
            lines.append(f"ratios within those predicted: {held.sum():.0f} of {count}")
    for column in [name for name in rows if name.startswith("interval_")]:
        name, found = column.removeprefix("interval_"), rows[column].value_counts()
        hits, misses = found.get("hit", 0), found.get("miss", 0)
        lines.append(f"interval of {name} holds: {hits} of {hits + misses}")
    lines.append(f"processor time of learn: median {rows['cpu'].median():.0f} s")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
