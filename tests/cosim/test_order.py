from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from stickslip.cosim.system.loops import stepping_order


def test_without_feedthrough_the_order_stays():
    assert stepping_order(["c", "a", "b"], []) == ["c", "a", "b"]


def test_the_loop_of_the_paper():
    names = ["drive", "controller", "compensator", "nominal"]
    feedthrough = [
        ("nominal.v", "compensator.v"),
        ("compensator.F", "controller.F"),
        ("controller.u", "drive.u"),
    ]
    order = stepping_order(names, feedthrough)
    assert order == ["nominal", "compensator", "controller", "drive"]


@given(st.permutations(range(8)), st.sets(st.tuples(st.integers(0, 7), st.integers(0, 7))))
def test_every_source_comes_first(ranks, pairs):
    names = [f"c{i}" for i in range(8)]
    edges = [(f"c{a}.y", f"c{b}.u") for a, b in pairs if ranks[a] < ranks[b]]
    order = stepping_order(names, edges)
    assert sorted(order) == names
    for source, target in edges:
        assert order.index(source[:2]) < order.index(target[:2])
