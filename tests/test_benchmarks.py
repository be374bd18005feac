"""``python -m benchmarks`` prints what it measured, and replaces stored figures only on request."""

import sys

import pytest

from benchmarks import __main__ as command
from benchmarks.coupling import report, steps


@pytest.mark.parametrize("options", [[], ["--write"]], ids=["", "--write"])
def test_stored_figures_change_only_on_request(monkeypatch, tmp_path, capsys, options):
    times = {steps.PLAIN: 1.0, steps.IN_TURN: 1.5, "cosim, Gauss-Seidel": 1.6}
    loops = {steps.CANDIDATE_LOOP: 1.0, steps.CANDIDATE_IN_TURN: 1.5, "cosim": 1.2}
    for name, found in {
        "measure_steps": times,
        "measure_candidate": loops,
        "measure_peers": {"libcosimpy": 4e3},
    }.items():
        monkeypatch.setattr(report, name, lambda *_, found=found: dict(found))
    for name in ("by_fmus", "by_variables", "by_steps"):
        monkeypatch.setattr(report, name, lambda *_: {3: 5.0, 30: 6.0})
    monkeypatch.setattr(report, "by_threads", lambda _: 1.9)
    monkeypatch.setattr(report, "draw", lambda path, *_: path.touch())
    stored = tmp_path / "results"
    stored.mkdir()
    monkeypatch.setattr(command, "KEPT", stored)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["benchmarks", "coupling", *options])
    command.main()
    assert "cosim, Gauss-Seidel (x C loop, Gauss-Seidel)" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["results"]
    assert {path.name for path in stored.iterdir()} == set(report.NAMES if options else ())
