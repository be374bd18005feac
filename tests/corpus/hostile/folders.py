"""Folders, disks and other processes that are in the way of results."""

import atexit
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from stickslip.fmi.files import lock
from tests.corpus.hostile.case import Case, Content


def named(*names: str) -> str:
    """Return a manifest that names files."""
    return json.dumps({"sha256": dict.fromkeys(names, hashlib.sha256(b"a").hexdigest())})


OUT: dict[str, Content] = {"out/a": "a", "out/manifest.json": named("a")}
"""A folder of results."""
_NAMES = ("F_s", "F_c", "v_s", "sigma_0", "sigma_1")
LEARNED = json.dumps({"parameters": {name: {"value": 1.0} for name in _NAMES}})


def _case(name: str, about: str, says: str, command: str, files: Mapping[str, Content]) -> Case:
    return Case(23, name, about, says, command, files)


def _held(path: Path) -> None:
    """Write a lock that this process holds."""
    path.write_text("4711\n")
    held = path.open("r+")
    atexit.register(held.close)
    lock(held)


def _link(path: Path) -> None:
    """Link to ``file`` in the folder of the case."""
    folder = path.parent if path.parent.name != "out" else path.parent.parent
    path.symlink_to(folder / "file")


CASES = [
    _case("results-into-a-file", "a file of the name that the folder of results is to have", ".*file: cannot write there .*choose another folder", "identify --out file", {"file": "of someone"}),
    _case("results-into-a-long-name", "a folder whose name is longer than the file system takes", ".*cannot write there .*choose another folder", f"compare learned.json --out {'x' * 300}", {"learned.json": LEARNED}),
    _case("results-of-another-process", "a folder that another process writes at this moment", ".*out: process 4711 is writing there; wait", "reproduce --out out", OUT | {"out/.stickslip-lock": _held}),
    _case("lock-as-a-link", "a lock that is a link to somebody's file", ".*is a symbolic link, expected a plain file", "reproduce --out out", OUT | {"file": "of someone", "out/.stickslip-lock": _link}),
    _case("two-studies-one-folder", "an unfinished study of a fleet in the folder", ".*unfinished: an earlier study did not end; continue with --resume", "fleet drives.csv --out out", {"drives.csv": "name,log\na,b.csv\n", "out/unfinished/manifest.json": '{"command": {"name": "a"}, "sha256": {}}'}),
    _case("file-as-a-folder", "a folder of the name that a file is to have", ".*plan.csv: is a folder, expected a plain file", "plan --out plan.csv", {"plan.csv": Path.mkdir}),
    _case("file-as-a-link", "a link of the name that a file is to have", ".*plan.csv: is a symbolic link, expected a plain file", "plan --out plan.csv", {"file": "of someone", "plan.csv": _link}),
    _case("file-below-a-file", "a file where the folder of a file is to be", ".*file.*: Not a directory|.*file.*: File exists", "plan --out file/plan.csv", {"file": "of someone"}),
    _case("results-of-a-run-into-a-folder", "a folder of the name that the signals of a run are to have", ".*run.csv: is a folder, expected a plain file", "simulate model.fmu --out run.csv", {"run.csv": Path.mkdir}),
    _case("results-changed", "results of which a file was changed", ".*out: 1 changed, 0 intact", "verify out", OUT | {"out/a": "b"}),
    _case("results-missing", "results of which a file was deleted", ".*out: 1 missing, 0 intact", "verify out", {"out/manifest.json": named("a")}),
    _case("results-with-more", "results with a file that no command wrote", ".*out: 1 additional, 1 intact", "verify out", OUT | {"out/compensator.fmu": "a"}),
    _case("results-as-a-link", "a link in place of a result", r".*out: 1 unreadable \(is a symbolic link.*\), 0 intact", "verify out", OUT | {"file": "of someone", "out/a": _link}),
    _case("manifest-cut-off", "a manifest that was cut off", ".*manifest.json: not a manifest of results", "verify out", OUT | {"out/manifest.json": '{"sha256": {"a": "0'}),
    _case("manifest-too-deep", "a manifest of 100,000 lists in each other", ".*manifest.json: not a manifest of results", "verify out", OUT | {"out/manifest.json": "[" * 100_000}),
    _case("manifest-too-long", "a manifest of 34 MB", ".*manifest.json: cannot be read .*34000000 bytes, at most", "verify out", OUT | {"out/manifest.json": " " * 34_000_000}),
    _case("manifest-of-elsewhere", "a manifest with a name that leaves the folder", ".*manifest.json: not a manifest of results", "verify out", OUT | {"out/manifest.json": named("../file")}),
    _case("manifest-of-lines", "a manifest with a name of two lines", ".*manifest.json: not a manifest of results", "verify out", OUT | {"out/manifest.json": named("a\nstickslip: all is well")}),
    _case("ready-elsewhere", "a link to another folder in place of results that a killed process left", ".*new results are complete but not all in place .*is in the way, expected a folder", "verify out", OUT | {"file": Path.mkdir, "out/.stickslip-ready": _link}),
    _case("ready-and-a-folder-in-the-way", "results that a killed process left, and a folder in the place of one of them", ".*new results are complete but not all in place .*is a folder, expected a plain file", "verify out", OUT | {"out/a": Path.mkdir, "out/.stickslip-ready/manifest.json": named("a"), "out/.stickslip-ready/a": "a"}),
]  # fmt: skip
