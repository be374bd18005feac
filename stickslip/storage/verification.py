"""Whether a folder still holds the results that its manifest names."""

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from stickslip.errors import ResultsError, with_settings
from stickslip.storage.locking import PREFIX
from stickslip.storage.manifest import MANIFEST, Manifest, hash_of, refuse_places
from stickslip.storage.publishing import READY, complete, files_in

NOTES = {
    "unfinished/*": "of a study that did not end; continue with <resume>",
    f"{PREFIX}*": "of a process that writes or was killed; the next that writes deletes it",
}
"""Files that may accompany results, by pattern."""


@dataclass(frozen=True)
class Verdict:
    """What a folder holds."""

    intact: int  # number of files that are as they were written
    # by the names of the other files: missing, changed, additional, or why not read
    faults: dict[str, str]
    notes: dict[str, str]  # remarks on files

    def __str__(self) -> str:
        counts = Counter(self.faults.values())
        bad = [f"{n} {what}" for what, n in sorted(counts.items())]
        return ", ".join([*bad, f"{self.intact} intact"])


def verify(folder: Path, without: Sequence[str] = ()) -> Verdict:
    """Compare a folder with its manifest; what a killed process left ready is moved in first.

    Files of the patterns ``without`` are not compared, such as those a repository leaves out.
    Raises ResultsError when there is no such folder or no manifest in it, or UsageError when
    another process is replacing the results.
    """
    if not folder.is_dir():
        raise ResultsError(f"{folder}: there is no such folder")
    while True:
        complete(folder)
        manifest = Manifest.read(folder)
        verdict = _compare(folder, manifest, without)
        if manifest == Manifest.read(folder) and not os.path.lexists(folder / READY):
            return verdict  # else another process has replaced the results meanwhile


def _compare(folder: Path, manifest: Manifest, without: Sequence[str]) -> Verdict:
    additional = set(files_in(folder)) - manifest.sha256.keys() - {MANIFEST}
    unseen = dict.fromkeys(without, "not compared")
    states = dict.fromkeys(additional, "additional")
    for name, digest in manifest.sha256.items():
        left_out = any(fnmatchcase(name, pattern) for pattern in without)
        states[name] = "left out" if left_out else _state(folder, name, digest)
    intact = sum(not state for state in states.values())
    faults, notes = {}, {}
    for name, state in sorted(states.items()):
        patterns = unseen | (NOTES if state == "additional" else {})
        known = [note for pattern, note in patterns.items() if fnmatchcase(name, pattern)]
        if known:
            notes[name] = with_settings(known[0])
        elif state:
            faults[name] = state
    return Verdict(intact, faults, notes)


def _state(folder: Path, name: str, digest: str) -> str:
    """Return what is wrong with a file; nothing if it is as it was written."""
    try:
        refuse_places(folder, name)
        return "" if hash_of(folder / name) == digest else "changed"
    except FileNotFoundError:
        return "missing"
    except OSError as error:
        return f"unreadable ({error.strerror})"
