"""``stickslip reproduce --as-published`` leaves what its help promises."""

from dataclasses import replace
from functools import partial

import pandas as pd
import pytest

from stickslip import ga
from stickslip.cli import main
from stickslip.papers.lugre import published
from stickslip.papers.lugre.folder import PUBLISHED_FILES

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return what the command writes, with a tenth of the generations of the paper."""
    folder = tmp_path_factory.mktemp("published") / "results"
    drive = ["--set", "drive.F_c=4", "drive.F_s=5", "drive.m=8"]
    command = ["reproduce", "--as-published", "--seeds", "1", "--seed", "6"]
    short = partial(published.study_as_published, settings=replace(ga.PAPER, generations=10))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(published, "study_as_published", short)
        assert main([*command, "--out", str(folder), *drive]) == 0
    return folder


def test_all_files_are_there_and_tell_the_seed(folder):
    assert {path.name for path in folder.iterdir()} == {*PUBLISHED_FILES, "manifest.json"}
    for name in ("fitness", "learned"):
        assert set(pd.read_csv(folder / f"{name}.csv")["seed"]) == {6}
    panel = pd.read_csv(folder / "panel.csv")
    assert panel["method"].tolist() == ["start", "as_published", "logarithmic", "least_squares"]


@pytest.mark.parametrize(
    "option",
    [
        ["--mode", "record"],
        ["--algorithm", "cma"],
        ["--pool", "processes"],
        ["--coarse", "F_c=2"],
        ["--complete"],
    ],
    ids=" ".join,
)
def test_options_that_mean_nothing_to_it_are_refused(option, tmp_path, capsys):
    out = tmp_path / "results"
    assert main(["reproduce", "--as-published", "--out", str(out), *option]) != 0
    message = capsys.readouterr().err
    assert option[0] in message
    assert message.count("\n") == 1
    assert not out.exists()
