"""The judge, who reads with eyes of its own, finds fault with hostile files too, and survives."""

from __future__ import annotations

import pytest

from benchmarks.hostile import archives, descriptions
from stickslip.cli import main

ARCHIVES = [case for case in archives.CASES if case.group != 3]
ARRAYS = [case for case in descriptions.CASES if case.group == 12 and "huge" in case.name]


@pytest.mark.parametrize("case", [*ARCHIVES, *ARRAYS], ids=str)
def test_a_hostile_file_is_found_at_fault(case, tmp_path, capsys):
    _, file, *_ = case.make(tmp_path)
    assert main(["check", "--no-run", str(file)]) == 1
    told = capsys.readouterr()
    assert " error " in told.out or "directory" in told.err
    assert "Traceback" not in told.out + told.err
