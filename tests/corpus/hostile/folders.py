"""Folders, disks and other processes that are in the way of results."""

from __future__ import annotations

import atexit
import hashlib
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from stickslip.fmi.files import lock
from tests.corpus.hostile.case import Case

LEARNING = 23
DIGEST = hashlib.sha256(b"a").hexdigest()


def results(folder: Path, *, manifest: str | None = None, **files: str) -> Path:
    """Write a folder of results: one file ``a``, and what is given."""
    out = folder / "out"
    out.mkdir()
    content = json.dumps({"sha256": {"a": DIGEST}}) if manifest is None else manifest
    for name, text in {"a": "a", "manifest.json": content, **files}.items():
        (out / name).write_text(text, encoding="utf-8")
    return out


def verified(spoil: Callable[[Path], object]) -> Callable[[Path], Sequence[str | Path]]:
    """Return what writes results, spoils them and has them verified."""

    def make(folder: Path) -> Sequence[str | Path]:
        out = results(folder)
        spoil(out)
        return ["verify", out]

    return make


def described(manifest: str) -> Callable[[Path], Sequence[str | Path]]:
    """Return what writes results with another manifest and has them verified."""
    return lambda folder: ["verify", results(folder, manifest=manifest)]


def named(*names: str) -> str:
    """Return a manifest that names files."""
    return json.dumps({"sha256": dict.fromkeys(names, DIGEST)})


def _file(folder: Path) -> Path:
    (folder / "file").write_text("of someone")
    return folder / "file"


def _link(folder: Path) -> Path:
    (folder / "plan.csv").symlink_to(_file(folder))
    return folder / "plan.csv"


def _folder(folder: Path, name: str) -> Path:
    (folder / name).mkdir()
    return folder / name


def _pipe(path: Path) -> Path:
    os.mkfifo(path)
    return path


def _locked(folder: Path) -> Path:
    out = results(folder, **{".stickslip-lock": "4711\n"})
    held = (out / ".stickslip-lock").open("r+")
    atexit.register(held.close)
    lock(held)
    return out


def _lock_that_is_a_link(folder: Path) -> Path:
    out = results(folder)
    (out / ".stickslip-lock").symlink_to(_file(folder))
    return out


def _ready_elsewhere(out: Path) -> None:
    other = out.parent / "other"
    other.mkdir()
    (out / ".stickslip-ready").symlink_to(other)


def _ready_and_a_folder_in_the_way(out: Path) -> None:
    ready = out / ".stickslip-ready"
    ready.mkdir()
    (ready / "manifest.json").write_text(named("a"))
    (ready / "a").write_text("a")
    (out / "a").unlink()
    (out / "a").mkdir()


def _replaced(out: Path, by: Callable[[Path], object]) -> None:
    (out / "a").unlink()
    by(out / "a")


def _fleet(folder: Path) -> Sequence[str | Path]:
    table = folder / "drives.csv"
    table.write_text("name,set\na,drive.m=9\n")
    unfinished = _folder(_folder(folder, "out"), "unfinished")
    (unfinished / "manifest.json").write_text('{"command": {"name": "a"}, "sha256": {}}')
    return ["fleet", table, "--out", folder / "out"]


CASES = [
    Case(
        LEARNING,
        "results-into-a-file",
        "a file of the name that the folder of results is to have",
        lambda f: ["identify", "--out", _file(f)],
        ".*file: cannot write there .*choose another folder",
    ),
    Case(
        LEARNING,
        "results-below-a-file",
        "a file where a parent of the folder is to be",
        lambda f: ["reproduce", "--out", _file(f) / "below"],
        ".*below: cannot write there .*choose another folder",
    ),
    Case(
        LEARNING,
        "results-into-a-long-name",
        "a folder whose name is longer than the file system takes",
        lambda f: ["validate", "--parameters", _learned(f), "--out", f / ("x" * 300)],
        ".*cannot write there .*choose another folder",
    ),
    Case(
        LEARNING,
        "results-of-another-process",
        "a folder that another process writes at this moment",
        lambda f: ["reproduce", "--out", _locked(f)],
        ".*out: process 4711 is writing there; wait",
    ),
    Case(LEARNING, "lock-as-a-link", "a lock that is a link to somebody's file", lambda f: ["reproduce", "--out", _lock_that_is_a_link(f)], ".*is a symbolic link, expected a plain file"),
    Case(
        LEARNING,
        "two-learnings-one-checkpoint",
        "the checkpoint of another learning in the folder",
        lambda f: ["reproduce", "--out", results(f, **{"learning.checkpoint.json": "{}"})],
        ".*learning.checkpoint.json: an earlier run did not end; go on with --resume",
    ),
    Case(LEARNING, "two-studies-one-folder", "an unfinished study of a fleet in the folder", _fleet, ".*unfinished: an earlier study did not end; go on with --resume"),
    Case(LEARNING, "file-as-a-folder", "a folder of the name that a file is to have", lambda f: ["plan", "--out", _folder(f, "plan.csv")], ".*plan.csv: is a folder, expected a plain file"),
    Case(LEARNING, "file-as-a-link", "a link of the name that a file is to have", lambda f: ["plan", "--out", _link(f)], ".*plan.csv: is a symbolic link, expected a plain file"),
    Case(
        LEARNING,
        "file-as-a-pipe",
        "a pipe that nobody reads of the name that a file is to have",
        lambda f: ["plan", "--out", _pipe(f / "plan.csv")],
        ".*plan.csv: is a device, expected a plain file",
    ),
    Case(LEARNING, "file-below-a-file", "a file where the folder of a file is to be", lambda f: ["plan", "--out", _file(f) / "plan.csv"], ".*file.*: Not a directory|.*file.*: File exists"),
    Case(
        LEARNING,
        "results-of-a-run-into-a-folder",
        "a folder of the name that the signals of a run are to have",
        lambda f: ["simulate", "model.fmu", "--out", _folder(f, "run.csv")],
        ".*run.csv: is a folder, expected a plain file",
    ),
    Case(LEARNING, "results-changed", "results of which a file was changed", verified(lambda out: (out / "a").write_text("b")), ".*out: 1 changed, 0 intact"),
    Case(LEARNING, "results-missing", "results of which a file was deleted", verified(lambda out: (out / "a").unlink()), ".*out: 1 missing, 0 intact"),
    Case(LEARNING, "results-with-more", "results with a file that no command wrote", verified(lambda out: (out / "compensator.fmu").write_text("a")), ".*out: 1 additional, 1 intact"),
    Case(
        LEARNING,
        "results-as-a-link",
        "a link in place of a result",
        verified(lambda out: _replaced(out, lambda p: p.symlink_to(_file(out.parent)))),
        r".*out: 1 unreadable \(is a symbolic link.*\), 0 intact",
    ),
    Case(LEARNING, "results-as-a-pipe", "a pipe that nobody writes in place of a result", verified(lambda out: _replaced(out, _pipe)), r".*out: 1 unreadable \(is a device.*\), 0 intact"),
    Case(LEARNING, "manifest-missing", "results without manifest", verified(lambda out: (out / "manifest.json").unlink()), ".*manifest.json: there is none"),
    Case(LEARNING, "manifest-cut-off", "a manifest that was cut off", described('{"sha256": {"a": "0'), ".*manifest.json: no manifest of results"),
    Case(LEARNING, "manifest-too-deep", "a manifest of 100,000 lists in each other", described("[" * 100_000), ".*manifest.json: no manifest of results"),
    Case(LEARNING, "manifest-too-long", "a manifest of 34 MB", described(" " * 34_000_000), ".*manifest.json: cannot be read .*34000000 bytes, at most"),
    Case(LEARNING, "manifest-of-elsewhere", "a manifest with a name that leaves the folder", described(named("../file")), ".*names '../file', which is no name of a file in the folder"),
    Case(LEARNING, "manifest-of-the-root", "a manifest with an absolute name", described(named("/etc/hostname")), ".*names '/etc/hostname', which is no name of a file in the folder"),
    Case(LEARNING, "manifest-of-lines", "a manifest with a name of two lines", described(named("a\nstickslip: all is well")), ".*which is no name of a file in the folder"),
    Case(LEARNING, "manifest-of-half-characters", "a manifest with a name that no file system can have", described(named("a\ud800")), ".*which is no name of a file in the folder"),
    Case(
        LEARNING,
        "ready-elsewhere",
        "a link to another folder in place of results that a killed process left",
        verified(_ready_elsewhere),
        ".*new results are complete but not all in place .*is in the way, expected a folder",
    ),
    Case(
        LEARNING,
        "ready-and-a-folder-in-the-way",
        "results that a killed process left, and a folder in the place of one of them",
        verified(_ready_and_a_folder_in_the_way),
        ".*new results are complete but not all in place .*is a folder, expected a plain file",
    ),
]  # fmt: skip


def _learned(folder: Path) -> Path:
    names = ("F_s", "F_c", "v_s", "sigma_0", "sigma_1")
    path = folder / "learned.json"
    path.write_text(json.dumps({"parameters": {name: {"value": 1.0} for name in names}}))
    return path
