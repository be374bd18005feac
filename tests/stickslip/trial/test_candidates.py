"""Compensators that ``learn`` compares on the drives that a log supports."""

from contextlib import closing
from dataclasses import replace
from functools import partial, partialmethod
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.catalog.parameters import friction_law
from stickslip.compensators.entrants import parts
from stickslip.errors import UsageError
from stickslip.evaluation.motions import VALIDATION
from stickslip.servo.axis import Axis, Datasheet
from stickslip.servo.chain_response import frequencies
from stickslip.servo.sensitivity import OpenLoop
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_filter import Observer, VelocityFilter
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop
from stickslip.thresholds import harm, offer
from stickslip.trial import benefit as trial_benefit
from stickslip.trial import candidates as trial_candidates
from stickslip.trial.benefit import (
    Bench,
    Benefit,
    TrialError,
    Variant,
    bench_of,
    best_of,
    feedforward,
    harmful,
)
from stickslip.trial.candidates import (
    CompensatorComparison,
    Row,
    _Candidates,
    compare,
    law_of,
    offered,
)
from stickslip.trial.compensator_trial import soft_rise, unseen
from stickslip.trial.family import SLOW_MOVE, SWEEP, Drive, Evidence, family

AXIS = Axis(80.0, 100.0, 1e-3)
FRICTION = {"F_s": 80.0, "F_c": 60.0, "v_s": 1e-3, "sigma_0": 4e6, "sigma_1": 8e3, "delta": 1.0}
LAW = friction_law()
LOOP = design_velocity_loop(AXIS, LoopSpecification(30.0, 55.0, 5e-4, 1e-3))
QUICK = replace(VALIDATION, height=0.2, slope=2.0, plateau=0.1)
MASSES = (0.9, 1.0, 1.2)
FEEDFORWARDS = {"static", *("lugre", "dahl", "gms", "coulomb_stribeck", "leuven")}


@pytest.fixture(scope="module")
def compared():
    """Return a function that compares compensators on four drives and two commands.

    One drive is stiffer than the fitted one: the log does not show presliding.
    """
    sheet = Datasheet(peak_force=1e4, tau_i=AXIS.tau_i, encoder_step=1e-7)
    stiffer = {**FRICTION, "sigma_0": 20.0 * FRICTION["sigma_0"]}
    drives = family(LAW, FRICTION, QUICK, Evidence({"lugre": [stiffer]}))[:4]
    with (
        bench_of(LAW, LOOP, FRICTION, drives, QUICK, sheet) as whole,
        closing(replace(whole, commands=whole.commands[1::2])) as bench,
    ):
        own = best_of(bench.benefits([feedforward(FRICTION)]))
        yield lambda **asked: compare(bench, own, FRICTION, MASSES, **asked)


def test_an_observer_alone_is_tried_with_the_command_as_its_reference(monkeypatch):
    """What the nominal loop gives, no block hands to it."""
    values = {name: FRICTION[name] for name in ("F_s", "F_c", "v_s", "sigma_0", "sigma_1")}
    observer = Compensator("observer", "lugre_observer", {"k_e": 1.0, **values})
    alone = Variant("alone", (observer,))
    behind = Variant("behind", (*feedforward(FRICTION).chain, observer))
    drives = [Drive("friction as fitted", LAW.name, {**FRICTION, "m": AXIS.m, "b": AXIS.b})]
    errors = {}
    for feed in ("own", "nominal", "command"):
        if feed != "own":
            monkeypatch.setattr(trial_benefit, "feed_of", lambda _, feed=feed: feed)
        with (
            bench_of(LAW, LOOP, FRICTION, drives, QUICK, Datasheet(1e4)) as whole,
            closing(replace(whole, commands=whole.commands[1:3])) as bench,
        ):
            for one in (alone, behind):
                (benefit,) = bench.benefits([one], shares=(1.0,))
                errors[one.name, feed] = [row.compensated for row in benefit.rows]
    for name, feed, other in (("alone", "command", "nominal"), ("behind", "nominal", "command")):
        assert errors[name, "own"] == errors[name, feed]
        assert errors[name, "own"] != errors[name, other]


def test_the_best_is_chosen_and_robust(compared):
    found = compared()
    rows = {row.name: row for row in found.rows}
    assert {"none", "static", "lugre"} < set(rows)
    assert {row.simplicity for row in found.rows} == {0, 1, 2, 3, 4}
    assert found.chosen.acceptable
    assert found.chosen.weighed <= (1.0 + offer.SIMPLER) * min(
        r.weighed for r in found.rows if r.acceptable
    )
    assert all(row.sensitivity <= offer.SENSITIVITY for row in found.rows)
    assert found.simpler.simplicity < found.chosen.simplicity
    swept = found.chosen.benefit.swept
    assert len(swept) == 4 * 28  # drives, and moves and creep
    assert max(row.ratio for row in swept) <= 2.0 - found.chosen.mean
    assert f"{found.simpler.name}, leaves {found.simpler.mean:.3g}" in found.sentence


def test_the_sensitivity_is_that_of_the_linear_loop(compared):
    row = compared(asked="ekbf").chosen
    values = row.designed.observer.parameters(LOOP)
    gains = {name: values[name] for name in ("L_x", "L_v", "L_d")}
    observer = Observer(VelocityFilter(AXIS, LOOP.T_s, **gains), values["share"])
    loops = [OpenLoop(LOOP, k * AXIS.m, frequencies(LOOP)) for k in MASSES]
    peak = max(loop.response(observer).peak for loop in loops)
    assert row.sensitivity == pytest.approx(peak, rel=1e-3)
    assert values["onset"] > 0.0
    assert row.choice == "observer"


def test_a_combination_rises_at_most_as_steeply_as_its_feedforward(compared):
    found = compared(asked="static+friedland_park")
    static, both = found.rows[1:]
    assert (static.name, both.name) == ("static", "static+friedland_park")
    steep, steepest = (
        one.benefit.share / one.benefit.variant.feedforward["v_t"] for one in (both, static)
    )
    assert steep <= steepest
    first, second = both.benefit.variant.chain
    assert (first.model, second.model) == ("static_feedforward", "momentum_observer")
    assert both.choice == "feedforward + observer"
    names = {row.name for row in compared(absent=("encoder", "motor_force")).rows}
    assert names == {"none", "static", "lugre"}  # without signals no observer


@pytest.mark.parametrize("law", ["lugre", "dahl", "gms", "leuven"])
def test_what_is_offered_needs_no_training_and_no_other_law(law):
    found = offered(friction_law(law))
    assert FEEDFORWARDS & found.keys() == {"static", law}
    assert {"ekbf", "dob", "friedland_park", "amin", "tafazoli"} <= found.keys()
    assert not any(parts()[name].learns for name in found)
    assert offered(friction_law(law), ["motor_force"]).keys() <= {"static", law, "lugre_observer"}


def row(name: str, simplicity: int, *ratios: float, motion: str = "motion {}") -> Row:
    rows = tuple(
        TrialError(0.01, f"drive {k}", 1.0, r, motion.format(k)) for k, r in enumerate(ratios)
    )
    return Row(name, simplicity, 1.3, Benefit(1.0, rows, rows))


on_drives = partial(row, motion="one")


def test_each_observer_is_tried_behind_one_feedforward_until_two_harm_nowhere():
    def tried(*harmful):
        rows = {name: row(name, 4, 1.5 if name in harmful else 0.5) for name in "abcde"}
        owner = SimpleNamespace(_observer=lambda _, part: [rows[part.name]])
        pairs = [(None, SimpleNamespace(name=name)) for name in "aabbcde"]
        return "".join(one.name for one in _Candidates._tried(owner, pairs))

    assert tried() == "ab"
    assert tried("a") == "abc"
    assert tried(*"abcde") == "abcd"


def test_a_tie_goes_to_the_simpler_and_what_harms_is_not_chosen():
    none = Row("none", 0, 1.3)
    law, observer, both = row("lugre", 2, 0.5), row("ekbf", 3, 0.4), row("both", 4, 0.39)
    assert CompensatorComparison((none, law, observer, both)).chosen == observer
    assert CompensatorComparison((none, law, replace(both, simplicity=4))).simpler == law
    harms = row("amin", 3, 0.01, 1.03)
    assert CompensatorComparison((none, law, harms)).chosen == law
    assert "lugre leaves 0.5" in CompensatorComparison((none, law, harms)).sentence
    assert CompensatorComparison((none, harms)).chosen == none
    assert CompensatorComparison((none, row("static", 1, 0.92))).chosen == none
    assert CompensatorComparison((none, harms), "amin").chosen == harms
    assert "worse than no compensator" in CompensatorComparison((none, harms), "amin").sentence


def test_of_two_that_are_alike_the_one_that_harms_no_drive_is_chosen():
    """The first leaves less in the mean, and up to 1.12 times the error of one drive."""
    risky = on_drives("risky", 3, *4 * (0.2,), 1.12)
    safe = on_drives("safe", 3, *4 * (0.21,), 1.0)
    assert risky.acceptable
    assert risky.mean < safe.mean
    assert CompensatorComparison((row("none", 0, 1.0), risky, safe)).chosen == safe
    for most in (0.5, 0.9):  # what one drive loses is not more than what all gain
        assert on_drives("it", 1, *4 * (most,), 1.13).acceptable == (most == 0.5)


def test_less_force_or_another_is_written_where_a_small_move_harms(compared, monkeypatch):
    """In the sweep, force above a part of that learned is made to harm, or any of it."""
    whole = compared(asked="lugre").chosen
    assert whole.benefit.share > 0.5
    swept = Bench.swept

    def harms(bench, variant, most, above):
        F_c = variant.feedforward.get("F_c", 0.0)
        row = TrialError(0.01, "a drive", 1.0, 2.0, SWEEP[0])
        if F_c > above * FRICTION["F_c"]:
            return (row,)
        return swept(bench, variant, most)

    monkeypatch.setattr(Bench, "swept", partialmethod(harms, above=0.5))
    less = compared(asked="lugre").chosen
    assert less.benefit.share == 0.5
    assert less.acceptable == (less.mean <= offer.GAIN)
    assert less.mean > whole.mean
    monkeypatch.setattr(Bench, "swept", partialmethod(harms, above=0.0))
    refused = compared(asked="lugre").chosen
    assert not refused.acceptable
    assert "in any small move" in refused.benefit.refusal
    assert not compared().chosen.benefit.variant.has_feedforward


def test_static_feedforward_rises_later_where_the_sweep_harms(compared, monkeypatch):
    later = compared(asked="static").chosen
    monkeypatch.setattr(trial_candidates, "LATE", ())
    less = compared(asked="static").chosen
    assert later.acceptable
    assert not less.acceptable
    assert later.benefit.share == 1.0
    ramps = [one.benefit.variant.feedforward["v_t"] for one in (later, less)]
    assert ramps[0] > ramps[1]


def test_static_feedforward_rises_later_where_all_of_it_harms(compared, monkeypatch):
    """At small velocities all of its force is made to harm, and half of it does not."""
    tried = Bench._tried

    def harms(bench, variant, cells):
        rows, own = tried(bench, variant, cells), variant.feedforward
        if own and own["v_t"] < 1e-3 and own["F_c"] > 0.6 * FRICTION["F_c"]:
            return tuple(replace(row, compensated=1.1 * row.without) for row in rows)
        return rows

    monkeypatch.setattr(Bench, "_tried", harms)
    monkeypatch.setattr(Bench, "swept", lambda *_: moves(0.5))
    found = compared(asked="static").chosen
    assert found.acceptable
    assert found.benefit.share == 1.0
    assert found.benefit.variant.feedforward["v_t"] > 1e-3


def test_an_observer_acts_later_where_small_moves_harm(compared, monkeypatch):
    """In the sweep, an onset below three times the first one is made to harm."""
    first = compared(asked="dob").chosen
    onset = first.designed.observer.values["onset"]
    swept = Bench.swept

    def harms(bench, variant, most):
        if variant.chain[-1].values["onset"] < 3.0 * onset:
            return (TrialError(0.01, "a drive", 1.0, 2.0, SWEEP[0]),)
        return swept(bench, variant, most)

    monkeypatch.setattr(Bench, "swept", harms)
    later = compared(asked="dob").chosen
    assert later.designed.observer.values["onset"] == pytest.approx(4.0 * onset)
    assert later.benefit.variant.chain[-1] == later.designed.observer
    assert later.mean > first.mean


def test_a_signal_that_no_controller_lacks_is_named():
    with pytest.raises(UsageError, match="absent: expected encoder or motor_force, got encode"):
        law_of("auto", "auto", ["encode"])


def moves(*ratios: float, name: str = SLOW_MOVE, speed: float = 1.0) -> tuple[TrialError, ...]:
    return tuple(TrialError(speed, f"drive {k}", 1.0, r, name) for k, r in enumerate(ratios))


def test_in_a_slow_move_most_drives_decide_and_in_others_each():
    assert not harmful(moves(1.2, 1.2, 2.5), 1.1)
    assert harmful(moves(1.4, 1.4, 1.0), 1.5)[1] == 1.3
    assert harmful((*moves(1.4, 1.4), *moves(1.0, 1.0, 1.0, speed=2.0)), 1.5)
    assert not harmful(moves(1.2, 1.2, 1.4, name=SWEEP[0]), 1.5)
    assert harmful(moves(1.0, 1.0, 1.2, name=SWEEP[0]), 1.1)[1] == 1.1


@pytest.mark.parametrize("name", SWEEP)
def test_one_drive_decides_where_most_of_three_motions_beside_each_other_are_worse(name):
    def swept(*ratios):
        every = enumerate(ratios)
        return sum((moves(0.5, one, 0.5, name=name, speed=1.0 + k) for k, one in every), ())

    assert not harmful(swept(1.4, 1.0, 1.0, 1.4, 1.0), 1.5)
    assert harmful(swept(1.0, 1.3, 0.9, 1.4, 1.0), 1.5) == (swept(0.0, 1.3)[4], harm.PERSISTS)
    found = Benefit(0.7, moves(0.5), moves(0.6), swept=swept(1.3, 1.3, 1.1))
    assert f"at 0.7 of its force the simulated tracking error in {name} of" in found.refusal
    assert "1.3 times that without the compensator; expected at most 1.2 times" in found.refusal


def test_a_rise_along_the_way_lets_no_drive_jump():
    """Where an encoder hides presliding, moves of a few deflections jump with a force of sign."""
    step = 1e-6
    rigid = {"F_c": 60.0, "F_s": 80.0, "v_s": 1e-3}
    known = Evidence({"lugre": unseen(4 * [{**rigid, "m": 80.0}], step)})
    law = friction_law("coulomb_stribeck")
    drives = family(law, rigid, QUICK, known)
    sheet = Datasheet(peak_force=1e4, tau_i=AXIS.tau_i, encoder_step=step)
    rise = soft_rise(60.0, drives, QUICK, step)
    length = 60.0 / rise.feedforward["sigma_0"]
    assert length == pytest.approx(45.0 * step)
    with bench_of(law, LOOP, rigid, drives, QUICK, sheet) as bench:
        worst = [
            max(one.ratio for one in bench.swept(x, np.inf)) for x in (rise, feedforward(rigid))
        ]
    assert worst[0] < 0.8 * worst[1]


def test_a_drive_that_breaks_away_by_chance_is_compared_with_its_next_moves(monkeypatch):
    """Without compensation one move has a tenth of the relative error of all others, or all do."""
    sheet = Datasheet(peak_force=1e4, tau_i=AXIS.tau_i, encoder_step=1e-6)
    drives = [Drive("a drive", "lugre", FRICTION)]
    with bench_of(LAW, LOOP, FRICTION, drives, VALIDATION, sheet) as bench:
        moves = [one for one in bench.sweep if one.name == SWEEP[0]]

        def worst(lucky):
            def errors(_, variant, cells):
                small = [one in lucky and not variant.chain for _, one in cells]
                return [
                    ((0.1 if tenth else 1.0) * one.speed,)
                    for tenth, (_, one) in zip(small, cells, strict=True)
                ]

            monkeypatch.setattr(Bench, "_errors", errors)
            return max(one.ratio for one in bench.swept(feedforward(FRICTION), np.inf))

        lucky = (moves[3:4], moves[3:6], moves)
        assert list(map(worst, lucky)) == pytest.approx([1.0, 10.0, 10.0])


def test_the_law_is_that_of_the_compensator():
    assert law_of("dahl+ekbf", "auto") == "dahl"
    assert law_of("static+ekbf", "auto") == "auto"
    assert law_of("auto", "gms") == "gms"
    with pytest.raises(UsageError, match="'gms': law is lugre"):
        law_of("gms", "lugre")


def test_a_feedforward_of_another_law_runs_with_it():
    """On a Dahl drive its own law leaves less than LuGre with half of the stiffness."""
    values = {"sigma_0": 4e6, "F_c": 60.0}
    rival = Compensator("compensator", "compensator", values, "compensator_dahl", law="dahl")
    drives = [Drive("a Dahl drive", "dahl", values)]
    sheet = Datasheet(peak_force=1e4, tau_i=AXIS.tau_i, encoder_step=1e-7)
    other = {**FRICTION, "F_s": 60.0, "sigma_0": 2e6}
    with bench_of(LAW, LOOP, FRICTION, drives, QUICK, sheet) as bench:
        own, lugre = bench.benefits([Variant("dahl", (rival,)), feedforward(other)], [1.0])
    assert own.mean_ratio < 0.9 * lugre.mean_ratio
    assert own.variant.share(LAW, 0.5).feedforward == {"sigma_0": 2e6, "F_c": 30.0}
