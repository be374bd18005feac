"""Checks FMUs of FMI 2.0 and FMI 3.0: archive, description, files, binaries, and how they run.

The bytes are read by ``stickslip.fmi``, as for the importer; the description is kept as it is
written, without the importer's defaults, so that the rules are stricter than the importer.
"""

from importlib import import_module

from stickslip.fmucheck.checker import check
from stickslip.fmucheck.rules import RULES, Finding, Report, Rule, Severity

__all__ = ["RULES", "Finding", "Report", "Rule", "Severity", "check"]
_THEMES = (
    *("archive", "document"),
    *(f"description.{name}" for name in ("identity", "variables", "structure", "capabilities")),
    *("files", "binaries"),
    *(f"running.{name}" for name in ("plain_run", "repeating", "dependencies", "calling")),
    *("running.continuous", "ending"),
)
for _theme in _THEMES:  # importing a theme registers its rules
    import_module(f"stickslip.fmucheck.{_theme}")
