"""The table of a fleet is read as it stands, or refused with row and column."""

import pytest

from stickslip.errors import UsageError
from stickslip.studies.fleet.table import read_fleet


def read(tmp_path, text):
    table = tmp_path / "fleet.csv"
    table.write_text(text, encoding="utf-8")
    return read_fleet(table)


def test_rows_become_drives_with_paths_beside_the_table(tmp_path):
    text = '\ufeffname,config,log\none, one.toml ,logs/one.csv\n\n"two",,"/logs/a,b.mat"\n'
    one, two = read(tmp_path, text)
    assert one.files == {"log": tmp_path / "logs/one.csv", "config": tmp_path / "one.toml"}
    assert {key: path.as_posix() for key, path in two.files.items()} == {"log": "/logs/a,b.mat"}
    assert one.row == {"name": "one", "log": "logs/one.csv", "config": "one.toml"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,log,log\na,b,c\n", "column 'log' is there twice"),
        ("name,config\na,b\n", "expected columns name and log, got name, config"),
        ("name,log\na,b\n,c\n", "row 3, column name: expected letters.*got nothing"),
        ("name,log\na,b\nA,c\n", "row 3, column name: 'A' is there already"),
        (
            "name,log,config\na,,c\n",
            "row 2, column log: expected the log .*got nothing",
        ),
    ],
)
def test_a_bad_table_is_refused_in_one_line(tmp_path, text, message):
    """Others are among the hostile inputs."""
    with pytest.raises(UsageError, match=message) as refused:
        read(tmp_path, text)
    assert str(refused.value).startswith(str(tmp_path / "fleet.csv"))
    assert "\n" not in str(refused.value)
