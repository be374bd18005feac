"""Defects of the binary: name in ``model.c``, rule, and the versions it exists in."""

from pathlib import Path

from tests.corpus.defects.reference import Members, Seed, Writer, binary_name, pack, with_defect

_BOTH = [
    ("version", "wrong-version-string"),
    ("refuses-token", "refuses-its-token"),
    ("any-token", "accepts-any-token"),
    ("step-fails", "does-not-run"),
    ("warns", "warns-in-a-plain-run"),
    ("terminate", "does-not-terminate"),
    ("crash", "crash"),
    ("abort", "crash"),
    ("stack", "crash"),
    ("unload", "crash"),
    ("exit", "ends-the-process"),
    ("hang", "hang"),
    ("flood", "floods-output"),
    ("prints", "prints"),
    ("output-nan", "value-not-finite"),
    ("leaves-range", "leaves-its-range"),
    ("other-start", "start-differs"),
    ("set-lost", "set-value-is-lost"),
    ("set-refused", "set-refused"),
    ("parameter-moves", "fixed-value-changes"),
    ("time", "time-is-wrong"),
    ("getter", "getter-changes-state"),
    ("random", "second-run-differs"),
    ("shared-state", "instances-share-state"),
    ("reset-forgets", "reset-forgets-something"),
    ("fixed-step", "variable-steps-fail"),
    ("process", "other-process-differs"),
    ("restore-forgets", "restored-state-differs"),
    ("saving-moves", "saving-changes-the-run"),
    ("freed-stays", "freed-state-stays"),
    ("bytes-lose", "serialised-state-differs"),
    ("bytes-point", "state-lost-in-other-process"),
    ("slope", "wrong-directional-derivative"),
    ("feedthrough", "undeclared-dependency"),
    ("any-reference", "unknown-reference"),
    ("zero-step", "bad-step"),
    ("step-any-time", "step-before-initialisation"),
    ("free-null", "freeing-nothing"),
    ("category", "undeclared-category"),
    ("logs-off", "logs-when-off"),
    ("environment", "foreign-environment"),
    ("debug-logging", "debug-logging-fails"),
    ("leak", "leaks-memory"),
    ("locale-folder", "changes-the-process"),
    ("rounding", "changes-the-process"),
    ("daemon", "leaves-a-process"),
    ("deletes", "changes-its-files"),
    ("indicators", "wrong-count"),
    ("derivative-nan", "derivative-not-finite"),
    ("states-lost", "state-not-set"),
    ("history", "rates-depend-on-history"),
    ("nominal", "bad-state-nominal"),
    ("iterates", "does-not-run"),
    ("nonlinear", "wrong-dependency-kind"),
    ("reset-fails", "call-fails"),
    ("input-stuck", "fails-when-inputs-move"),
    ("null-message", "bad-message"),
]
_FMI2 = [("platform", "wrong-types-platform"), ("callbacks", "memory-callbacks-used")]
_FMI3 = [
    ("exact-start", "undeclared-dependency"),
    ("adjoint", "wrong-adjoint-derivative"),
    ("needs-logger", "needs-a-logger"),
    ("states-count", "wrong-count"),
    ("early-return", "does-not-run"),
]


def _with(version: int, defect: str) -> Writer:
    def write(path: Path, content: Members) -> None:
        pack(path, content | {binary_name(version): with_defect(defect)})

    return write


SEEDS = [
    Seed("binary", version, rule, defect, _with(version, defect))
    for version, table in ((2, _BOTH), (3, _BOTH), (2, _FMI2), (3, _FMI3))
    for defect, rule in table
]
