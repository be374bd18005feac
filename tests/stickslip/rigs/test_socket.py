"""A drive behind a socket: the log of the FMU, one start whatever is lost, and always a stop."""

import itertools
import runpy
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import stickslip
from stickslip import Command, Datasheet, FmuRig, RigLimits, SocketRig
from stickslip.errors import LimitError, RigError
from stickslip.rigs.lines import LOOP, Lines, crc_of, line_of
from stickslip.rigs.served_drive import Ports, ServedDrive
from stickslip.rigs.server import Server
from stickslip.servo import axis

WIDE = RigLimits(travel=(-0.2, 0.2), speed=1.0, force=250.0, following_error=0.05)
T_S = axis.LOOP.T_s


@contextmanager
def served(fmus, *, fast=True, heartbeat=5.0, port=0):
    """Return the drive and the port of a server in a thread."""
    controller = fmus / "velocity_controller.fmu"
    drive = ServedDrive(fmus / "drive.fmu", controller, T_S, Ports())
    server = Server(drive, ("localhost", port), "drive", heartbeat=heartbeat, fast=fast)
    end = threading.Event()
    thread = threading.Thread(target=server.serve, args=(end.is_set,))
    thread.start()
    try:
        yield drive, server.port
    finally:
        end.set()
        thread.join()
        drive.close()


def rig_at(port, limits=WIDE, **how):
    return SocketRig(f"localhost:{port}", Datasheet(), limits, **how)


def command_of(rig, n=450):
    t = np.arange(n) * rig.T_s
    v = 0.03 * np.sin(2 * np.pi * 5 * t)
    return Command(rig.T_s, rig.loop, velocity=v, added_force=2.0 * np.sign(v))


CONNECT = socket.create_connection


class Unreliable:
    """A connection that loses, delays and doubles messages of both sides, and is cut."""

    EVERY: ClassVar = {"cut": 31, "lost": 7, "late": 9, "doubled": 11}
    number, fates = itertools.count(1), Counter()

    def __init__(self, *place):
        self._real, self._lines = CONNECT(*place), Lines()
        self._late = {self.sendall: b"", self.recv: b""}

    def __getattr__(self, name):
        return getattr(self._real, name)

    def _passed(self, line, way):
        k = next(self.number)
        fate = next((name for name, n in self.EVERY.items() if k % n == 0), "")
        self.fates[fate] += 1
        if fate == "cut":
            self._real.close()
            raise OSError("the line was cut")
        late, self._late[way] = self._late[way], b""
        if fate == "late":  # behind the next one
            self._late[way] = late + line
            return b""
        return line * {"lost": 0, "doubled": 2}.get(fate, 1) + late

    def sendall(self, line):
        self._real.sendall(self._passed(line, self.sendall))

    def recv(self, size):
        while received := self._real.recv(size):
            lines = map(line_of, self._lines.messages(received))
            if passed := b"".join([self._passed(line, self.recv) for line in lines]):
                return passed
        return b""


def test_the_first_motion_is_that_of_the_fmu_and_each_begins_at_0(fmus):
    with served(fmus) as (drive, port), rig_at(port) as rig:
        near = FmuRig(fmus, Datasheet(), T_S)
        command = command_of(rig)
        found, expected = rig.run(command), near.run(command)
        np.testing.assert_array_equal(found.x_enc, expected.x_enc)
        np.testing.assert_array_equal(found.F_m, expected.F_m)
        assert abs(drive.position) > 1e-4
        second = rig.run(command)
        assert abs(second.x_enc[0]) <= 2e-5
        np.testing.assert_allclose(second.x_enc, expected.x_enc, atol=1e-4)
        pushed = rig.push(np.full(200, 20.0))
        assert pushed.x_enc[-1] > 5e-3
        assert drive.state == "idle"


@pytest.mark.thorough
def test_messages_that_are_lost_late_or_doubled_change_nothing(fmus, monkeypatch):
    with served(fmus) as (drive, port), rig_at(port) as rig:
        expected, again = (rig.run(command_of(rig, 2000)) for _ in range(2))
        motions = drive.motion
    monkeypatch.setattr(socket, "create_connection", Unreliable)
    with served(fmus) as (drive, port), rig_at(port, retry=0.05) as rig:
        found = [rig.run(command_of(rig, 2000)) for _ in range(2)]
        assert drive.motion == motions
    for one, other in zip(found, (expected, again), strict=True):
        np.testing.assert_array_equal(one.x_enc, other.x_enc)
        np.testing.assert_array_equal(one.F_m, other.F_m)
    assert {*Unreliable.EVERY} <= {*Unreliable.fates}


def load(rig, motion=1, n=4000):
    """Load a motion of n samples, request by request; return what starts it."""
    signals = {"v_cmd": np.full(n, 0.02)}
    for k in range(0, n, 500):
        part = {"v_cmd": signals["v_cmd"][k : k + 500].tolist()}
        rig._request("load", motion=motion, values=part, **{"from": k})
    loop = dict.fromkeys(LOOP, 0.0) | {"K_p": 1500.0, "K_i": 1e5, "tau_f": 5e-4}
    loop["velocity_feedforward"] = 1.0
    return {"samples": n, "crc": crc_of(signals), "loop": loop, "limits": asdict(WIDE)}


def read(rig, begin=0, **fields):
    return rig._request("read", motion=1, **{"from": begin}, **fields)


def test_a_drive_that_nobody_asks_about_stops(fmus):
    with served(fmus, fast=False, heartbeat=0.2) as (drive, port), rig_at(port) as rig:
        heard = rig._request("start", motion=1, **load(rig))["clock"]
        for _ in range(5):  # the same heartbeat again and again does not count
            time.sleep(0.06)
            read(rig, 10**6, heard=heard)
        time.sleep(0.4)
        reply = read(rig)
        assert reply["state"] == "aborted"
        assert "no heartbeat for 0.2 s" in reply["reason"]
        assert 0.1 < reply["samples"] * T_S < 0.5
        assert drive.state == "idle"
        time.sleep(0.05)
        assert read(rig)["position"] == reply["position"]


def test_a_start_is_obeyed_once_and_never_late(fmus):
    with served(fmus, heartbeat=0.2) as (drive, port), rig_at(port) as rig:

        def refused(what, said, **fields):
            with pytest.raises(RigError, match=said):
                rig._request(what, **{"motion": 1, **fields})

        start, heard = load(rig, n=200), rig._heard
        time.sleep(0.25)
        refused("start", r"older than 0\.2 s", **start, heard=heard)
        assert drive.motion == 0
        refused("start", "not what was sent", **{**start, "crc": 1})
        rig._request("start", motion=1, **start)
        while (reply := read(rig))["state"] != "done":
            pass
        assert rig._request("start", motion=1, **start)["state"] == "done"
        assert read(rig)["position"] == reply["position"]
        refused("load", "has been started", values={}, **{"from": 0})
        refused("jump", "expected hello, load, start", motion=2)
        refused("start", "is not loaded", motion=2, **start)
        refused("load", "protocol 1", motion="x")


def test_garbage_neither_ends_nor_moves_a_drive(fmus):
    garbage = [b"GET / HTTP/1.1\r\n\r\n", b"[" * 100_000 + b"\n", b"null\n", b"\xff\n", b"{}\n"]
    with served(fmus) as (drive, port), rig_at(port) as rig:
        for line in garbage:
            with socket.create_connection(("localhost", port)) as connection:
                connection.sendall(line)
                connection.recv(1000)
        broken = replace(rig.loop, K_p=-1e300)
        with pytest.raises(RigError, match="the controller refuses its loop"):
            rig.follow(np.zeros(10), broken)
        assert (drive.state, drive.motion) == ("idle", 0)
        assert len(rig.run(command_of(rig)).t) == 450


def test_a_limit_aborts_in_the_drive_and_another_program_has_to_wait(fmus):
    with served(fmus) as (drive, port):
        with rig_at(port, replace(WIDE, travel=(-0.01, 0.01))) as rig:
            with pytest.raises(LimitError, match=r"aborted at 0\.\d+ s: position 0\.01\d* m"):
                rig.push(np.full(2000, 20.0))
            assert drive.state == "idle"
            assert 0.01 < drive.position < 0.06
            rig.follow(np.full(100, 0.01), rig.loop)  # the next begins at 0 again
        with rig_at(port) as first, rig_at(port), pytest.raises(RigError, match="another program"):
            first.push(np.zeros(10))


def test_a_server_that_is_killed_is_one_error(fmus):
    command = [sys.executable, "-m", "stickslip", "serve", str(fmus / "drive.fmu"), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        port = server.stdout.readline().split(":")[-1]
        with rig_at(int(port), patience=0.5) as rig:
            killer = threading.Timer(0.3, server.send_signal, [signal.SIGKILL])
            killer.start()
            with pytest.raises(RigError, match=r"connection lost for 0\.5 s .*is not repeated"):
                rig.follow(np.full(4000, 0.02), rig.loop)


def test_a_drive_that_fails_says_so_and_moves_no_more(fmus, monkeypatch):
    with served(fmus) as (drive, port), rig_at(port) as rig:
        step, calls = drive._drive.step, itertools.count()
        lost = {"fmu.x_enc": np.nan, "fmu.F_m": 0.0}
        monkeypatch.setattr(drive._drive, "step", lambda u: step(u) if next(calls) < 100 else lost)
        with pytest.raises(RigError, match=r"motion 1 of .* failed: position nan m, force 0\.0 N"):
            rig.run(command_of(rig))
        with pytest.raises(RigError, match="refuses to start: the drive FMU failed"):
            rig.run(command_of(rig))


def test_the_example_moves_a_served_drive_within_its_limits_and_keeps_the_logs(
    fmus, tmp_path, monkeypatch
):
    """Up to the learning, which takes half a minute: two motions instead of it."""
    example = Path(__file__).parents[3] / "examples" / "real_drive.py"
    done, moved, port = [], [], 0

    def learn(rig, limits):
        log = rig.run(command_of(rig))
        done.append((limits, log))
        with pytest.raises(LimitError):
            rig.push(np.full(200, 150.0))
        raise KeyboardInterrupt

    monkeypatch.setattr(stickslip, "learn", learn)
    monkeypatch.chdir(tmp_path)
    for _ in range(2):  # the second goes on with the logs of the first
        with served(fmus, port=port) as (drive, port):
            monkeypatch.setattr(sys, "argv", [str(example), f"localhost:{port}"])
            with pytest.raises(KeyboardInterrupt):
                runpy.run_path(str(example))
            moved.append(drive.motion)
    assert moved == [1, 0]
    (limits, first), (_, second) = done
    assert limits.speed == 0.04
    np.testing.assert_array_equal(first.x_enc, second.x_enc)
    assert (tmp_path / "drive_1/motions/motion-0001.npz").exists()


def test_a_limit_that_is_infinite_is_sent_as_one(fmus):
    inf = float("inf")
    wide = RigLimits((-inf, inf), inf, inf, inf)
    with served(fmus) as (drive, port), rig_at(port, wide) as rig:
        assert len(rig.run(command_of(rig)).t) == 450
        assert drive._watch.limits == wide


@pytest.mark.parametrize("line", [b'{"seq": 1}\n' * 50, b'{"session": "x"}\n' * 5000])
def test_a_client_that_does_not_read_delays_no_sample(fmus, line):
    with served(fmus, fast=False) as (_, port), rig_at(port) as rig, ExitStack() as held:
        rig._request("start", motion=1, **load(rig, n=20_000))
        for _ in range(3):
            flood = held.enter_context(socket.create_connection(("localhost", port)))
            flood.setblocking(False)
            with suppress(OSError):
                while True:
                    flood.sendall(line)
        reply = read(rig)
        assert reply["state"] == "moving"
        assert reply["late"] < 0.8  # a second and more while the server waited for one of them
