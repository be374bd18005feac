"""With what a page was made."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from stickslip.report.markup import Html, table

PACKAGES = ("stickslip", "numpy", "scipy", "control", "pandas", "fmpy", "ziglang", "matplotlib")


def made_with() -> Html:
    """Return a table of versions."""
    versions = [(name, _version(name)) for name in PACKAGES]
    rows = [("Python", platform.python_version()), *versions]
    return table(("Package", "Version"), rows, "Made with", (0, 1))


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
