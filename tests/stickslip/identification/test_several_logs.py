"""Several logs of one drive: what they have in common, and what one of them contradicts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import stickslip as ss
from stickslip.identification.criteria.controller_check import check_reading
from stickslip.identification.criteria.inverse_model import ForceCost, InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.runs import RECENT, Runs
from stickslip.identification.estimation import agreement
from stickslip.identification.estimation.agreement import contradictions
from stickslip.identification.fitting.search import best_fit
from stickslip.identification.fitting.start import begin
from stickslip.identification.sliding.log_offsets import with_log_offsets
from stickslip.logs import Controller, Reading
from stickslip.logs.checked import shortened
from stickslip.logs.joined import join
from stickslip.planning import SET, Limits, plan
from stickslip.servo.measurement import smoothed
from stickslip.thresholds import log_content
from tests.kept import further
from tests.stickslip.identification import drives

TRUTH = {"m": 5.557, "b": 6.6135, "F_c": 5.999}


def recorded(kind, duration=3.0, **changes):
    """Return the log of a kind of motion, of the paper's stage or one that differs."""
    command = plan(Limits(duration=duration), (), SET[kind])
    more = {"noise": 0.02, "source": f"{kind}.csv", **changes}
    return drives.recording("lugre", command["velocity_command"].to_numpy(), **more)


def joined(*logs, loads=None, gains=None):
    return join(logs, gains or [drives.GAINS] * len(logs), loads or [0.0] * len(logs))


def fitted(fmus, recording):
    with InverseModel(fmus, recording) as inverse:
        start = begin(inverse, recording)
        found = best_fit(inverse.over(start.space), start, start.line)
        return found, [*contradictions(inverse, found)]


@pytest.fixture(scope="module")
def logs():
    return {kind: recorded(kind) for kind in SET}


def test_logs_of_other_motions_show_together_what_one_alone_does_not(candidates, logs):
    found, contradicted = fitted(candidates, joined(logs["creep"], logs["sliding"]))
    alone, _ = fitted(candidates, logs["sliding"])
    assert not contradicted
    for name in ("m", "F_c", "F_s"):
        assert found.parameters[name] == pytest.approx(drives.STAGE[name], rel=0.02), name
    assert found.errors()["F_s"] < 0.5 * alone.errors()["F_s"]


def test_stretches_of_a_long_log_show_what_no_part_of_it_does(candidates, monkeypatch):
    """Creep and sliding lie farther apart than what is used of the log is long."""
    monkeypatch.setattr(log_content, "LONGEST", 6.0)
    monkeypatch.setattr(log_content, "MOST", 0)
    parts = [plan(Limits(duration=6.0), (), SET[kind]) for kind in ("creep", "sliding")]
    creep, sliding = (part["velocity_command"].to_numpy() for part in parts)
    rest = np.zeros(10 * len(creep))
    long = drives.recording("lugre", np.concatenate([creep, rest, sliding]), noise=0.02)
    stretches, _ = shortened(long)
    found, contradicted = fitted(candidates, stretches)
    alone, _ = fitted(candidates, shortened(long, number=1)[0])
    assert not contradicted
    for name in ("m", "F_c", "F_s"):
        assert found.parameters[name] == pytest.approx(drives.STAGE[name], rel=0.03), name
    assert found.errors()["F_s"] < 0.5 * alone.errors()["F_s"]
    check = check_reading(Reading(stretches, Controller("PI", **drives.GAINS)))
    assert check.error < 0.02  # each stretch begins with a memory of its own


@pytest.mark.thorough
@pytest.mark.parametrize("share", [1.5, *further(0.6)])
def test_a_log_whose_force_is_out_of_scale_is_named_with_its_factor(candidates, logs, share):
    wrong = replace(logs["creep"], force=share * logs["creep"].force)
    again = replace(logs["sliding"], source="again.csv")
    _, (finding,) = fitted(candidates, joined(logs["sliding"], wrong, again))
    assert finding.what == "creep.csv contradicts the other 2 logs"
    assert finding.spoils == "values"
    factor = float(finding.figure.partition("its friction is ")[2].split()[0])
    assert factor == pytest.approx(share, rel=0.05)


def test_the_load_of_a_log_is_not_the_mass_of_the_drive(candidates, logs):
    heavy = recorded("sliding", m=TRUTH["m"] + 3.0)
    found, contradicted = fitted(
        candidates, joined(logs["sliding"], replace(heavy, source="heavy.csv"), loads=[0.0, 3.0])
    )
    assert not contradicted
    assert found.parameters["m"] == pytest.approx(TRUTH["m"], rel=0.01)
    _, contradicted = fitted(candidates, joined(logs["sliding"], heavy))
    assert contradicted


def test_a_rise_towards_rest_that_others_do_not_show_is_no_other_friction():
    """Creep beside logs that are too fast for it: what they tell of it is extrapolated."""
    t, T_s = np.arange(4000), 1e-3
    v = np.sign(np.sin(1e-2 * t)) * (1.0 + 0.8 * np.sin(7e-3 * t))

    def friction(values):
        rise = values["F_s"] - values["F_c"]
        return np.sign(v) * (values["F_c"] + rise * np.exp(-np.abs(v) / 3.0))

    values = {"m": 1.0, "b": 0.0, "F_c": 1.0, "F_s": 2.0, "F_0": 0.0}
    inverse = SimpleNamespace(
        t=t,
        T_s=T_s,
        used=slice(0, 4000),
        logs=[slice(0, 4000)],
        cutoff=200.0,
        moves=np.full(4000, True),
        motion=SimpleNamespace(v=v),
        linear=np.column_stack([0.0 * v, 0.0 * v, np.ones_like(v)]),
        friction=friction,
    )
    for k, told in (({"F_s": 1.3}, False), ({"F_c": 1.4, "F_s": 2.8}, True)):
        inverse.measured = lambda _, k=k: smoothed(friction({**values, **k}), T_s, 200.0)
        differs, _ = agreement._differences(inverse, values, 0)
        assert any("friction" in one for one in differs) == told


def test_a_log_that_nothing_of_its_own_explains_contradicts_none(candidates, logs, monkeypatch):
    wrong = replace(logs["sliding"], force=1.5 * logs["sliding"].force, source="wrong.csv")
    whole = joined(logs["sliding"], wrong)
    assert fitted(candidates, whole)[1]
    monkeypatch.setattr(agreement, "_differences", lambda *_: ([], 1e-3))
    assert not fitted(candidates, whole)[1]


def test_a_log_in_one_direction_differs_in_friction_and_not_in_a_constant_force(candidates, logs):
    """Its motion does not tell the two apart."""
    command, F_c = np.abs(logs["sliding"].velocity_command), 1.3 * TRUTH["F_c"]
    other = drives.recording("lugre", command, F_c=F_c, source="forward.csv")
    _, (finding,) = fitted(candidates, joined(logs["sliding"], other))
    assert finding.what == "forward.csv contradicts sliding.csv"
    factor = float(finding.figure.partition("its friction is ")[2].split()[0])
    assert factor == pytest.approx(1.3, rel=0.05)
    assert "constant force" not in finding.figure


def test_another_constant_force_of_a_log_is_taken_out_of_it(logs):
    pulled = replace(logs["sliding"], force=logs["sliding"].force + 2.0, source="pulled.csv")
    whole, (finding,) = with_log_offsets(joined(logs["sliding"], pulled))
    first, second = (whole.log(one).known_force for one in whole.segments)
    assert np.all(first == 0.0)
    assert second == pytest.approx(np.full(len(second), 2.0), abs=0.15)
    assert "pulled.csv" in finding.figure
    same = joined(logs["sliding"], replace(logs["sliding"], source="again.csv"))
    assert with_log_offsets(same) == (same, ())


def test_each_log_runs_with_its_own_gains_and_load(candidates):
    stiff = {**drives.GAINS, "K_p": 3000.0}
    one, other = recorded("sliding"), recorded("sliding", K_p=3000.0, m=TRUTH["m"] + 2.0)
    whole = joined(one, other, gains=[drives.GAINS, stiff], loads=[0.0, 2.0])
    values = {**drives.STAGE, "F_0": 0.0, "delay": 0.0, "delta": 2.0}
    names = (*TRUTH, "F_s", "v_s", "sigma_0", "sigma_1", "delta", "F_0", "delay")
    with KnownLoop(candidates, whole, drives.GAINS) as loop:
        found = loop.run({name: values[name] for name in names})["candidate.x"]
    for segment in whole.segments:
        log = slice(segment.begin, segment.end)
        assert found[log] == pytest.approx(whole.position[log], abs=2e-5)


@pytest.mark.thorough
def test_a_set_is_learned_from_its_table_without_the_log_that_contradicts(tmp_path):
    rows = ["log,kind,use"]
    recordings = {kind: recorded(kind, duration=5.0) for kind in SET}
    sliding = recordings["sliding"]
    recordings["wrong"] = replace(sliding, force=1.4 * sliding.force)
    for kind, log in recordings.items():
        recorded_log = {"t": log.t, "position": log.position, "v_cmd": log.velocity_command}
        drives.write_log(tmp_path / f"{kind}.csv", recorded_log, force=log.force)
        rows.append(f"{kind}.csv,{kind},{'validate' if kind == 'presliding' else 'learn'}")
    (tmp_path / "runs.csv").write_text("\n".join(rows) + "\n")
    known = ss.Description(controller="PI", gains=drives.GAINS)
    learned = ss.learn(tmp_path, known)
    for name, truth in TRUTH.items():
        one = learned.estimation.known[name]
        assert one.low <= truth <= one.high, name
    own = next(one for one in learned.predicted if one.law == learned.estimation.law.title)
    static = next(one for one in learned.predicted if one.law == "Coulomb-Stribeck with F_s = F_c")
    assert own.source == "presliding.csv"
    left_out = "wrong.csv is left out: wrong.csv contradicts the other 2 logs"
    assert left_out in [one.what for one in learned.findings]
    assert own.error < static.error


def test_candidates_of_a_search_are_run_side_by_side_and_each_log_from_rest(
    candidates, logs, monkeypatch
):
    """Together they cost what each costs alone, and no run is made twice."""
    batches = []
    batch = Runs.batch

    def counted(runs, some):
        batches.append(len(some))
        return batch(runs, some)

    monkeypatch.setattr(Runs, "batch", counted)
    with InverseModel(candidates, joined(logs["creep"], logs["sliding"])) as inverse:
        start = begin(inverse, inverse.recording)
        names = start.space.friction
        cost = ForceCost(inverse, names, start.line["delay"])
        first = np.array([start.line[name] for name in names])
        rows = first * np.linspace(0.9, 1.1, RECENT + 2)[:, np.newaxis]
        batches.clear()
        together = [one() for one in cost.together(rows)]
        assert batches == [len(rows)] * 2  # one for each log
        assert together == [cost(row) for row in rows]
        assert batches == [len(rows)] * 2
        assert len({*together}) == len(rows)
