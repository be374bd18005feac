"""Headers and schemas of the FMI project, which FMPy's wheel carries."""

from importlib.util import find_spec
from pathlib import Path


def standard_files(folder: str) -> Path:
    """Return a folder of FMPy's wheel, ``c-code`` or ``schema``; importing FMPy would take long."""
    found = find_spec("fmpy")
    if found is None or not found.origin:
        what = "the headers and schemas of FMI are missing"
        raise ModuleNotFoundError(f"{what}; run 'pip install fmpy'")
    return Path(found.origin).parent / folder
