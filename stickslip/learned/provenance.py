"""Where the numbers of exported code come from, in lines for its head."""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from textwrap import wrap

from stickslip.errors import UsageError
from stickslip.fmi.files import digest
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import AXIS_KEYS
from stickslip.presentation.quantity import number
from stickslip.versions import installed_versions

WIDTH = 96  # characters of a line


def provenance(learned: LearnedFile, share: float | None = None, alone: str = "") -> list[str]:
    """Return the lines, of all blocks or for the file of one ``alone``; raise UsageError."""
    try:
        return [
            one
            for text in _texts(learned, share, alone)
            for one in wrap(text, WIDTH, subsequent_indent="    " if text[:2] == "  " else "  ")
        ]
    except (KeyError, TypeError, ValueError, ArithmeticError) as error:
        raise UsageError(
            f"{learned.path}: expected parameters and verdict as learn writes them; got {error!r}"
        ) from None


def loop_doubts(learned: LearnedFile) -> list[str]:
    """Return why the loop for which the values were computed may not be that of the drive."""
    verdict = learned.mapping("verdict")
    said = (*verdict.get("refused", ()), *verdict.get("doubts", ()))
    return [one for one in said if "loop" in one]


def _texts(learned: LearnedFile, share: float | None, alone: str) -> Iterator[str]:
    document = learned.document
    date = datetime.fromtimestamp(learned.path.stat().st_mtime, UTC)
    logs = [f"{name} (SHA-256 {value})" for name, value in learned.mapping("sha256").items()]
    yield f"Drive: {document.get('motion', 'linear')}, learned on {date:%Y-%m-%d} from"
    yield from (f"  {one}" for one in logs or [document.get("log", "a rig or the simulated drive")])
    yield f"File: {learned.path.name} (SHA-256 {digest(learned.path)})"
    version = learned.mapping("versions").get("stickslip", "unknown")
    own = installed_versions(["stickslip"]).get("stickslip", "unknown")
    yield f"Version: learned with stickslip {version}, exported with {own}"
    yield f"Learned values of the law {learned.law.title}, with 95 % intervals:"
    for name, one in learned.mapping("parameters").items():
        ends = [one.get(end) for end in ("low", "high")]
        span = "" if None in ends else ", {:.5g} to {:.5g}".format(*ends)
        level = f", {one['identifiability']}" if "identifiability" in one else ""
        yield f"  {name} = {one['value']:.5g} {one.get('unit', '')}{span}{level}"
    if share is not None and share != 1.0:
        entry = (learned.mapping("feedforward") or document).get("share", {})
        why = f", because {entry['reason']}" if "reason" in entry else ""
        yield f"Share: the code has {100.0 * share:g} % of the learned friction{why}"
    gains = ", ".join(
        f"{name} = {one['value']:.5g} {one.get('unit', '')}".removesuffix(" 1")
        for name, one in learned.mapping("loop").items()
        if name not in AXIS_KEYS
    )
    yield f"Loop for which it was computed: {gains or 'gains not known'}"
    yield from loop_doubts(learned)
    if sample := learned.mapping("T_s").get("value"):
        yield f"Sample period: {sample:g} s"
    verdict = learned.mapping("verdict")
    named = [f"{Path(one).stem}{Path(alone).suffix}" for one in learned.written]
    others = [one for one in named if alone and "written" in document and one != alone]
    if others:
        yield f"What learn wrote, to be used as a whole: {' and '.join(named)}"
    if tuned := learned.mapping("tuning").get("sentence"):
        yield f"Tuned with its loop: {tuned}"
    if errors := verdict.get("errors"):
        leaves = f"leaves, with {' and '.join(others)}:" if others else "leaves:"
        yield f"Predicted share of the error that friction causes that what was written {leaves}"
        for one in errors:
            shares = one["left"] / one["without"], one["low"], one["high"]
            left, low, high = (number(100.0 * each, 2) for each in shares)
            yield f"  {one['figure']}, {one['motion']}: {left} % ({low} to {high} % expected)"
