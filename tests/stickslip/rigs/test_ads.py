"""A drive behind a Beckhoff controller: its function block, interpreted, on the drive FMU."""

import math
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pyads", reason="pyads is not installed: pip install 'stickslip[ads]'")
from stickslip import AdsRig, Datasheet, FmuRig
from stickslip.errors import LimitError, RigError, UsageError
from stickslip.rigs import ads_rig
from stickslip.rigs.remote import RemoteRig
from stickslip.servo import axis
from stickslip.thresholds import rig_motion
from tests.stickslip.rigs.plc import controller
from tests.stickslip.rigs.test_socket import WIDE, command_of

pytestmark = [
    pytest.mark.skipif(
        sys.platform != "linux", reason="the simulated controller needs addresses of Linux"
    ),
    # the server of pyads leaves sockets and threads to their fate
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]
T_S = axis.LOOP.T_s
PUSH, STEP = np.full(2000, 20.0), np.full(2000, 0.1)  # N, m/s


def rig_at(ip, limits=WIDE, **how):
    return AdsRig(f"{ip}.1.1", Datasheet(), limits, **how)


@pytest.fixture(autouse=True)
def _unpaced(monkeypatch):
    """A busy machine may call the function block late."""
    monkeypatch.setattr(rig_motion, "PACE", math.inf)
    monkeypatch.setattr(ads_rig, "ANSWER", 10.0)


def test_a_wrong_period_of_the_task_is_found(fmus, monkeypatch):
    monkeypatch.undo()
    with controller(fmus, T_S) as (plc, ip), rig_at(ip) as rig:
        plc.period = 4 * T_S
        with pytest.raises(RigError, match=r"expected T_s = 0\.0005 s to be the period in which"):
            rig.run(command_of(rig))


def test_the_function_block_runs_what_the_fmus_run(fmus):
    with controller(fmus, T_S) as (plc, ip), rig_at(ip) as rig:
        assert rig.T_s == T_S
        command = command_of(rig)
        found, expected = rig.run(command), FmuRig(fmus, Datasheet(), T_S).run(command)
        np.testing.assert_allclose(found.x_enc, expected.x_enc, atol=1e-9)
        np.testing.assert_allclose(found.F_m, expected.F_m, atol=1e-6)
        assert plc["state"] == 0
        assert abs(plc.measured[0]) > 1e-4
        again = rig.run(command)  # returns to 0 before
        assert abs(again.x_enc[0]) <= 2e-5
        np.testing.assert_allclose(again.x_enc, expected.x_enc, atol=1e-4)
        pushed = rig.push(np.full(400, 20.0))
        assert pushed.x_enc[-1] > 5e-3
        np.testing.assert_allclose(pushed.F_m[50:], 20.0, rtol=0.05)


@pytest.mark.parametrize(
    ("limits", "move", "said"),
    [
        ({"travel": (-0.01, 0.01)}, lambda rig: rig.push(PUSH), r"position 0\.01\d* m"),
        ({"speed": 0.05}, lambda rig: rig.push(PUSH), r"speed 0\.05\d* m/s"),
        ({"force": 20.0}, lambda rig: rig.follow(STEP, rig.loop), r"force 1\d\d[.\d]* N"),
        (
            {"following_error": 1e-4},
            lambda rig: rig.follow(STEP, rig.loop),
            r"following error 0\.000",
        ),
    ],
)
def test_a_limit_aborts_in_the_controller(fmus, limits, move, said):
    with controller(fmus, T_S) as (plc, ip), rig_at(ip, replace(WIDE, **limits)) as rig:
        with pytest.raises(LimitError, match=r"aborted at \S+ s: " + said):
            move(rig)
        assert (plc["state"], plc["enable"], plc["F"]) == (0, False, 0.0)
        assert plc["k"] < 2000


@pytest.mark.parametrize(("heartbeat", "fault"), [(0.2, 6), (5.0, 7)])
def test_a_program_that_dies_or_is_interrupted_stops_the_drive(fmus, monkeypatch, heartbeat, fault):
    """One that dies does not say so; the drive stops without its heartbeat."""
    with controller(fmus, T_S, heartbeat=heartbeat) as (plc, ip), rig_at(ip) as rig:
        if fault == 6:
            monkeypatch.setattr(RemoteRig, "_stop", lambda *_: None)

        def read(asked):
            if asked["motion"] == rig._number and plc["k"] > 100:
                raise KeyboardInterrupt
            return AdsRig._read(rig, asked)

        monkeypatch.setattr(rig, "_read", read)
        with pytest.raises(KeyboardInterrupt):
            rig.follow(np.full(4000, 0.02), rig.loop)
        time.sleep(1.0)
        assert (plc["state"], plc["fault"]) == (0, fault)
        where = plc.measured[0]
        assert 0.0 < where < 0.05
        time.sleep(0.1)
        assert plc.measured[0] == where


def test_a_connection_that_is_lost_is_one_error_and_the_drive_stops(fmus):
    with controller(fmus, T_S, heartbeat=0.2) as (plc, ip), rig_at(ip, patience=0.5) as rig:
        plc.silent_from = 200
        with pytest.raises(RigError, match=r"connection lost for 0\.5 s .*is not repeated"):
            rig.follow(np.full(8000, 0.02), rig.loop)
        time.sleep(0.5)
        assert (plc["state"], plc["fault"]) == (0, 6)
        plc.silent_from = math.inf
        rig.follow(np.full(100, 0.01), rig.loop)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("fault", 99, "its answer to 'read' is not of protocol 1: KeyError 99"),
        ("k", 10**6, r"MAIN\.rig\.x_log\[\d+\]: symbol not found"),
    ],
)
def test_a_controller_that_says_nonsense_is_one_error(fmus, name, value, said):
    with controller(fmus, T_S) as (plc, ip), rig_at(ip) as rig:
        plc.running = False
        plc.block.variables[name] = value
        with pytest.raises(RigError, match=said):
            rig._request("read", motion=1, **{"from": 10**6 - 1 if name == "k" else 0})


def test_two_programs_do_not_move_one_drive(fmus):
    with (
        controller(fmus, T_S) as (plc, ip),
        rig_at(ip) as first,
        rig_at(ip),
        pytest.raises(RigError, match="another program has taken"),
    ):
        first.push(np.zeros(10))
    assert plc["motion"] == 0


def test_what_is_missing_is_said_in_one_line(fmus, monkeypatch):
    with controller(fmus, T_S) as (plc, ip), rig_at(ip) as rig:
        with pytest.raises(RigError, match=r"MAIN\.fb\.state: symbol not found.*StickslipRig"):
            rig_at(ip, symbol="MAIN.fb")
        plc.inputs["ready"] = False
        with pytest.raises(RigError, match=r"refuses to start: .* not ready"):
            rig.run(command_of(rig))
        plc.inputs["ready"] = True
        with pytest.raises(RigError, match="longer than the arrays of StickslipRig, 8000 samples"):
            rig.push(np.zeros(9000))
        plc.running = False
        monkeypatch.setattr(ads_rig, "ANSWER", 1.0)
        with pytest.raises(RigError, match=r"was not called for 1 s"):
            rig.run(command_of(rig))
    with pytest.raises(RigError, match=r"connection lost for 0\.1 s .*refused"):
        rig_at("127.0.0.1", patience=0.1)
    for wrong in ("localhost", "1.2.3.4", ""):
        with pytest.raises(UsageError, match="AMS net id of six numbers"):
            AdsRig(wrong, Datasheet(), WIDE)
    monkeypatch.setitem(sys.modules, "pyads", None)
    with pytest.raises(UsageError, match=r"pip install '.*\[ads\]'"):
        rig_at(ip)
