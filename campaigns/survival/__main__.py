"""``python -m campaigns.survival``: do results survive what happens to computers?"""

import tempfile
from collections import Counter
from pathlib import Path

from campaigns.survival.trials import (
    fill_at_each_operation,
    fill_for_real,
    kill_at_each_operation,
    kill_at_random,
    plain,
    remove_at_random,
    small_disk,
)
from stickslip.output import SILENT
from stickslip.papers.lugre.folder import write_results
from stickslip.papers.lugre.reproduction import Options, Reproduction, reproduce
from stickslip.servo.systems import build_fmus

KILLS = 50


def _reproduction(folder: Path, **truth: float) -> Reproduction:
    folder.mkdir()
    build_fmus(folder, truth)
    return reproduce(Options(truth=truth), folder, SILENT)


def _say(what: str, outcomes: Counter[str]) -> None:
    print(what)
    for outcome, n in sorted(outcomes.items()):
        print(f"  {n:5}  {outcome}", flush=True)


def main() -> None:
    """Run all of it; a set that is lost raises."""
    with tempfile.TemporaryDirectory(prefix="stickslip-") as name:
        folder = Path(name)
        both = [_reproduction(folder / "fmus1"), _reproduction(folder / "fmus2", F_c=5.0)]
        first, second = (lambda f, r=r: write_results(r, f) for r in both)
        _say(
            "killed by SIGKILL at random moments while write_results replaces the paper's results",
            kill_at_random(folder / "results", (first, second), KILLS),
        )
        first(folder / "a")
        second(folder / "b")
        old, new = plain(folder / "a"), plain(folder / "b")
        _say(
            f"killed before each operation on files, {len(new)} files",
            kill_at_each_operation(folder / "killed", old, new),
        )
        for stays, how in ((False, "each operation once"), (True, "all operations from the n-th")):
            _say(
                f"no room for {how}",
                fill_at_each_operation(folder / "full", old, new, stays=stays),
            )
        try:
            with small_disk(folder / "disk", 12_000_000) as disk:
                _say("a disk with ever less room", fill_for_real(disk, old, new, 20))
        except OSError as error:
            print(f"a disk with ever less room: not tried, {error}")
        _say(
            "the folder removed at random moments",
            remove_at_random(folder / "removed", new, KILLS),
        )


if __name__ == "__main__":
    main()
