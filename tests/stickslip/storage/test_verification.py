"""``stickslip verify`` names each file that is not as it was written."""

import json
import os
from pathlib import Path

import pytest

from stickslip.cli import main

PAPER = Path(__file__).parents[3] / "results" / "paper"
HASH = "0" * 64


def verify(capsys, folder, *options):
    """Return status, lines on standard output, lines on standard error."""
    status = main(["verify", str(folder), *options])
    out, err = capsys.readouterr()
    return status, out.splitlines(), err.splitlines()


def test_each_fault_is_a_line(folder, capsys):
    (folder / "a").write_text("other")
    (folder / "b").unlink()
    (folder / "sub").mkdir()
    (folder / "sub" / "c").touch()
    (folder / "new\nline").touch()
    status, lines, said = verify(capsys, folder)
    assert status == 1
    assert lines == [
        f"{folder}/a: changed",
        f"{folder}/b: missing",
        f"{folder}/'new\\nline': additional",
        f"{folder}/sub/c: additional",
    ]
    assert said == [f"stickslip: {folder}: 2 additional, 1 changed, 1 missing, 0 intact"]


def test_files_of_a_run_that_goes_on_are_told_and_no_fault(folder, capsys):
    (folder / "unfinished" / "a").mkdir(parents=True)
    (folder / "unfinished" / "a" / "learned.json").touch()
    status, lines, _ = verify(capsys, folder)
    assert status == 0
    assert sum("continue with --resume" in line for line in lines) == 1


NO_NAMES = (
    *("../a", "/etc/passwd", "sub/../../a", "", ".", "a//b", "a/", "c:/x", "a\\b"),
    *("a\x00b", "a\nb", "a\ud800", "manifest.json"),
)


@pytest.mark.parametrize(
    "content",
    [
        *("", "[" * 100_000, "[]", '{"sha256": []}', "{}", b"\xff\xfe{}"),
        '{"command": 1, "sha256": {}}',
        *(json.dumps({"sha256": {"a": value}}) for value in ("0", "A" * 64, 1)),
        *(json.dumps({"sha256": {name: HASH}}) for name in NO_NAMES),
        *('{"sha256": {}, "earlier": 1}', '{"sha256": {}, "earlier": [1]}'),
        '{"sha256": {}, "earlier": [{"command": {}, "files": ["x"]}]}',
    ],
)
def test_a_damaged_manifest_ends_in_one_line(folder, capsys, content):
    path = folder / "manifest.json"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    status, lines, errors = verify(capsys, folder)
    assert (status, lines, len(errors)) == (1, [], 1)
    assert f"{path}: not a manifest of results" in errors[0]


def test_a_folder_or_manifest_that_is_absent_a_link_or_a_pipe_is_told(folder, capsys):
    path = folder / "manifest.json"
    assert "there is no such folder" in verify(capsys, folder / "a")[2][0]
    assert "there is no such folder" in verify(capsys, folder / "none")[2][0]
    path.rename(folder / "real")
    assert "manifest.json: there is none" in verify(capsys, folder)[2][0]
    path.symlink_to("real")
    assert "is a symbolic link" in verify(capsys, folder)[2][0]
    path.unlink()
    os.mkfifo(path)
    assert "is a device" in verify(capsys, folder)[2][0]


def test_what_is_left_out_is_not_compared_whether_it_is_there_or_not(folder, capsys):
    """As FMUs of a later run beside the tables and the manifest of a checkout."""
    (folder / "a").write_text("of another run")
    (folder / "c").write_text("additional")
    without = ("--without", "[ac]")
    notes = [f"{folder / name}: not compared" for name in ("a", "c")]
    assert verify(capsys, folder, *without) == (0, [*notes, f"{folder}: 1 intact"], [])
    (folder / "a").unlink()
    assert verify(capsys, folder, *without)[0] == 0
    (folder / "b").write_text("of another run")
    assert verify(capsys, folder, *without)[0] == 1


def test_the_committed_results_are_those_that_were_written(capsys):
    """But for FMUs and packages, which the repository leaves out."""
    assert verify(capsys, PAPER, "--without", "*.fmu", "*.ssp")[0] == 0
