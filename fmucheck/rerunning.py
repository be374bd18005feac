"""Rules about a second process: it must come to the same."""

from __future__ import annotations

from stickslip.fmucheck.rules import Claims, error
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.repeating import difference
from stickslip.fmucheck.running.run import finished
from stickslip.fmucheck.running.saving import half_way, resumed


@error("2.1.5", "2.3.1", "leave out clocks, addresses and random numbers")
def other_process_differs(bench: Bench) -> Claims:
    """The same run in another process gives another result."""
    if "rows" in bench.first:
        expected = bench.first["rows"].split("\n")
        if where := difference(expected, finished(bench).rows):
            yield bench.interface.kind, f"two processes differ: {where}"


@error("2.1.8", "2.2.7", "write values, not addresses")
def state_lost_in_other_process(bench: Bench) -> Claims:
    """A state that was serialised in one process does not go on in another."""
    if "state" in bench.first:
        expected = bench.first["after"].split("\n")
        again = resumed(bench, half_way(bench), bytes.fromhex(bench.first["state"]))
        if where := difference(expected, again.rows):
            yield bench.interface.kind, f"after serialising into another process: {where}"
