"""Where the numbers of exported code come from, in lines for its head."""

from collections.abc import Iterator
from datetime import UTC, datetime
from textwrap import wrap
from typing import Any

from stickslip.errors import UsageError
from stickslip.fmi.files import digest
from stickslip.learned.file import LearnedFile
from stickslip.presentation.quantity import number
from stickslip.versions import installed_versions

WIDTH = 96  # characters of a line


def provenance(learned: LearnedFile, share: float | None = None) -> list[str]:
    """Return drive, logs, values, share of a feedforward and errors; raise UsageError."""
    try:
        texts = [
            (text, "    " if text.startswith("  ") else "  ") for text in _texts(learned, share)
        ]
        return [
            one for text, indent in texts for one in wrap(text, WIDTH, subsequent_indent=indent)
        ]
    except (KeyError, TypeError, ValueError, ArithmeticError) as error:
        raise UsageError(
            f"{learned.path}: expected parameters and verdict as learn writes them; got {error!r}"
        ) from None


def _texts(learned: LearnedFile, share: float | None) -> Iterator[str]:
    document = learned.document
    date = datetime.fromtimestamp(learned.path.stat().st_mtime, UTC)
    logs = [f"{name} (SHA-256 {value})" for name, value in _mapping(document, "sha256").items()]
    yield f"Drive: {document.get('motion', 'linear')}, learned on {date:%Y-%m-%d} from"
    yield from (f"  {one}" for one in logs or [document.get("log", "a rig or the simulated drive")])
    yield f"File: {learned.path.name} (SHA-256 {digest(learned.path)})"
    version = _mapping(document, "versions").get("stickslip", "unknown")
    own = installed_versions(["stickslip"]).get("stickslip", "unknown")
    yield f"Version: learned with stickslip {version}, exported with {own}"
    yield f"Learned values of the law {learned.law.title}, with 95 % intervals:"
    for name, one in _mapping(document, "parameters").items():
        ends = [one.get(end) for end in ("low", "high")]
        span = "" if None in ends else ", {:.5g} to {:.5g}".format(*ends)
        level = f", {one['identifiability']}" if "identifiability" in one else ""
        yield f"  {name} = {one['value']:.5g} {one.get('unit', '')}{span}{level}"
    if share is not None and share != 1.0:
        entry = _mapping(document.get("feedforward", document), "share")
        why = f", because {entry['reason']}" if "reason" in entry else ""
        yield f"Share: the code has {100.0 * share:g} % of the learned friction{why}"
    if sample := _mapping(document, "T_s").get("value"):
        yield f"Sample period: {sample:g} s"
    verdict = _mapping(document, "verdict")
    if errors := verdict.get("errors"):
        yield "Predicted share of the error that friction causes that what was written leaves:"
        for one in errors:
            shares = one["left"] / one["without"], one["low"], one["high"]
            left, low, high = (number(100.0 * each, 2) for each in shares)
            yield f"  {one['figure']}, {one['motion']}: {left} % ({low} to {high} % expected)"


def _mapping(document: Any, name: str) -> dict[str, Any]:
    entry = document.get(name)
    return entry if isinstance(entry, dict) else {}
