"""Every seeded defect is found by the rule that is meant for it."""

import warnings
from dataclasses import replace
from pathlib import Path

import pytest

from stickslip import fmucheck
from stickslip.fmi.process import sandbox
from stickslip.fmucheck import rules
from stickslip.fmucheck.running import parent
from stickslip.fmucheck.running.plain_run import GATES
from tests.corpus.defects import binaries, descriptions, files
from tests.corpus.defects.reference import binary_name, members, pack, with_defect

RUNS = ("running", "rerunning", "ending")  # stages that load the binary
TIMEOUT = 2.0  # s, for those that hang; others may start on a busy machine
BINARIES = {
    name: [seed for seed in binaries.SEEDS if seed.what == name]
    for name in dict.fromkeys(seed.what for seed in binaries.SEEDS)
}
# Each defect of a binary in one version of the standard, in turn; the benchmark takes both.
TURNS = [seeds[place % len(seeds)] for place, seeds in enumerate(BINARIES.values())]
SEEDS = [*descriptions.SEEDS, *files.SEEDS, *TURNS]
# What a rule of the second process compares with, another rule leaves in the first.
LEFT_BY = {
    "other-process-differs": "second-run-differs",
    "state-lost-in-other-process": "serialised-state-differs",
}
ALONE = ("warns", "time", "nominal", "bytes-point")


def report_of(path, rule=None):
    run = rule is None or fmucheck.RULES[rule].stage in RUNS
    return fmucheck.check(path, run=run, **{"timeout": TIMEOUT} if rule == "hang" else {})


@pytest.mark.parametrize("version", [2, 3])
def test_the_sound_fmu_is_found_sound(tmp_path, version):
    report = report_of(pack(tmp_path / "reference.fmu", members(version)))
    assert list(report) == []


def try_only(monkeypatch, rule):
    """Leave out what a run tries beside one rule and those without which none is tried."""
    needed = {*GATES, rule, LEFT_BY.get(rule)}
    tried = parent._tried

    def try_needed(job, *arguments):
        if job.stage == "rerunning" != fmucheck.RULES[rule].stage:
            return iter(())
        others = {each.id for each in rules.stage(job.stage)} - needed
        left = frozenset((kind, other) for kind in job.libraries for other in others)
        return tried(replace(job, tried=left), *arguments)

    monkeypatch.setattr(parent, "_tried", try_needed)


@pytest.mark.parametrize("seed", SEEDS, ids=lambda seed: seed.name)
def test_seeded_defect_is_found(tmp_path, monkeypatch, seed):
    """Of the rules that run it, the one for the defect is tried, however the process ends all."""
    with warnings.catch_warnings(action="ignore"):  # zipfile: two members of one name
        path = seed.make(tmp_path)
    if fmucheck.RULES[seed.rule].stage in ("running", "rerunning"):
        try_only(monkeypatch, seed.rule)
    report = report_of(path, seed.rule)
    assert seed.rule in report.rules
    assert "rule-not-tried" not in report.rules
    assert [p.name for p in tmp_path.iterdir()] == ["reference.fmu"]


@pytest.mark.parametrize("what", ALONE)
def test_no_other_rule_finds_the_defect(tmp_path, what):
    """Every rule is tried."""
    (seed,) = (seed for seed in TURNS if seed.what == what)
    assert report_of(seed.make(tmp_path)).rules == {seed.rule}


@pytest.mark.skipif(bool(sandbox.unavailable()), reason=sandbox.unavailable())
def test_what_an_fmu_reaches_for_is_denied_and_found(tmp_path):
    binary = {binary_name(2): with_defect("home")}
    path = pack(tmp_path / "reference.fmu", members(2) | binary)
    (found,) = fmucheck.check(path)
    assert (found.rule, found.place) == ("reaches-outside", f"read {Path.home()}")
    (open_now,) = fmucheck.check(path, allow=[f"files={Path.home()}"])
    assert "the home folder can be read" in open_now.message


def test_every_rule_has_a_seed():
    # In test_check.py and test_robustness.py; the last one tells of mistakes of ours.
    elsewhere = {"not-named-fmu", "unsigned-for-arm-mac", "rule-not-tried", "reaches-outside"}
    every = {s.rule for s in [*descriptions.SEEDS, *files.SEEDS, *binaries.SEEDS]}
    assert set(fmucheck.RULES) - every == elsewhere
