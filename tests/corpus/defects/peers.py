"""Other people's checkers, asked whether they have anything to say about an FMU."""

from __future__ import annotations

import logging
from pathlib import Path

from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox.checker import get_checkers
from fmu_manipulation_toolbox.operations import FMU


class _Counter(logging.Handler):
    """Counts warnings and errors."""

    count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += record.levelno >= logging.WARNING


def fmpy_complains(path: Path) -> bool:
    """Tell whether FMPy's validator reports a problem, be it by an exception."""
    try:
        return bool(validate_fmu(str(path)))
    except Exception:  # noqa: BLE001 (whatever it raises counts as found)
        return True


def toolbox_complains(path: Path) -> bool:
    """Tell whether the check of fmu-manipulation-toolbox reports a problem, likewise."""
    counter = _Counter()
    logger = logging.getLogger("fmu_manipulation_toolbox")
    logger.addHandler(counter)
    try:
        with FMU(str(path)) as fmu:
            for checker in get_checkers():
                fmu.apply_operation(checker())
    except (Exception, SystemExit):  # noqa: BLE001 (whatever it raises counts as found)
        return True
    finally:
        logger.removeHandler(counter)
    return counter.count > 0
