"""The table of a fleet is read as it stands, or refused with row and column."""

import pytest

from stickslip.errors import UsageError
from stickslip.studies.fleet.table import LogSource, read_fleet


def read(tmp_path, text):
    table = tmp_path / "fleet.csv"
    table.write_text(text, encoding="utf-8")
    return read_fleet(table)


def test_rows_become_drives_with_paths_beside_the_table(tmp_path):
    text = (
        "\ufeffname,config,log,set\n"
        "one, one.toml ,logs/one.csv,\n"
        "\n"
        "two,,,drive.m=10 drive.noise=on\n"
        '"three",,"/logs/a,b.mat",\n'
    )
    one, two, three = read(tmp_path, text)
    assert one.source == LogSource(tmp_path / "logs/one.csv", tmp_path / "one.toml")
    assert two.source == {"m": 10.0, "noise": 1.0}
    assert three.source.log.as_posix() == "/logs/a,b.mat"
    assert one.row == {"name": "one", "log": "logs/one.csv", "config": "one.toml"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,log,log\na,b,c\n", "column 'log' is there twice"),
        ("name,config\na,b\n", "expected columns name and log, or name and set, got name, config"),
        ("name,log\na,b\n,c\n", "row 3, column name: expected letters.*got nothing"),
        ("name,log\na,b\nA,c\n", "row 3, column name: 'A' is there already"),
        ("name,log,set\na,,\n", "row 2, column log: expected either a log or.*got nothing"),
        ("name,log,set\na,b,drive.m=1\n", "row 2, column log: .*got 'b and drive.m=1'"),
        ("name,set,config\na,drive.m=1,c\n", "row 2, column config: expected nothing.*got 'c'"),
        ("name,set\na,drive.m\n", "row 2, column set: drive.m: expected NAME=VALUE"),
        ("name,set\na,drive.mass=1\n", "row 2, column set: .*mass"),
    ],
)
def test_a_bad_table_is_refused_in_one_line(tmp_path, text, message):
    """Others are among the hostile inputs."""
    with pytest.raises(UsageError, match=message) as refused:
        read(tmp_path, text)
    assert str(refused.value).startswith(str(tmp_path / "fleet.csv"))
    assert "\n" not in str(refused.value)
