"""A rig in another process, behind a socket: the protocol is in docs/rig.md."""

import math
import secrets
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from stickslip.errors import LimitError, RigError, UsageError
from stickslip.planning import Limits
from stickslip.planning.parts import approach
from stickslip.rigs.contract import Command, Log, Rig
from stickslip.rigs.limits import RigLimits
from stickslip.rigs.lines import CHUNK, LOOP, PROTOCOL, Lines, crc_of, line_of, sent_limits
from stickslip.servo.axis import ControlError, Datasheet
from stickslip.thresholds import rig_motion

RETURNS, RETURN_SPEED, DWELL, K_X = 5, 0.02, 0.5, 20.0
"""Most moves back to 0, their speed [m/s], rest at their end [s] and position gain [1/s]."""
MARGIN = 1e-3  # by how much a move back may overshoot where it begins [m]


class Refusal(RigError):
    """A request was refused; nothing came of it."""


class SocketRig(Rig):
    """A drive behind a socket, such as that of ``stickslip serve``.

    Requests that get no answer are repeated; a motion is started once, whatever is lost or doubled.
    The drive stops by itself when this program does not ask for ``heartbeat`` seconds.

    Parameters
    ----------
    address : "host:port"
    datasheet : what is known of the drive
    limits : that abort a motion, there and here
    law : friction law of the compensator
    patience : how long a lost connection is tried again [s]
    retry : after which time a request is repeated [s]

    Raises
    ------
    RigError
        When there is no answer, or none of this protocol.
    UsageError
        When the address is not of this form.
    """

    def __init__(
        self,
        address: str,
        datasheet: Datasheet,
        limits: RigLimits,
        law: str = "lugre",
        *,
        patience: float = 5.0,
        retry: float = 0.1,
    ) -> None:
        host, _, port = address.rpartition(":")
        if not (host and port.isascii() and port.isdigit() and 0 < int(port) < 2**16):
            raise UsageError(f"rig {address!r}: expected HOST:PORT, a port from 1 to 65535")
        self._place, self._retry = (host, int(port)), retry
        self._session = secrets.token_hex(8)
        self._socket: socket.socket | None = None
        self._seq, self._heard = 0, 0.0
        self.name, self._limits, self._patience = address, limits, patience
        try:
            super().__init__(datasheet, self._greet(), limits, law)
        except BaseException:
            self._disconnect()
            raise

    def move(self, command: Command) -> Log:
        """Move back to 0 if the drive stands elsewhere, run a motion, and return its log."""
        if command.loop.velocity_filter is not None:
            raise RigError(f"{self.name}: cannot run a velocity filter in the drive")
        self._return()
        return self._run(command, self._limits)

    def close(self) -> None:
        """Close the connection; the drive is at rest."""
        super().close()
        self._disconnect()

    def _greet(self) -> float:
        """Say hello, and return the drive's sample period [s]."""
        hello = self._request("hello", protocol=PROTOCOL)
        with self._understood("hello"):
            T_s, self._heartbeat = float(hello["T_s"]), float(hello["heartbeat"])
            self._motion = self._number = int(hello["last"])
            spoken = hello["protocol"]
            if not (0.0 < T_s < math.inf and 0.0 < self._heartbeat < math.inf):
                raise ValueError(f"T_s = {T_s} s, heartbeat = {self._heartbeat} s")
            if spoken != PROTOCOL:
                raise ValueError(f"protocol {spoken!r}")
        return T_s

    def _return(self) -> None:
        """Move to 0, by a position loop around the velocity loop."""
        for _ in range(RETURNS):
            reply = self._request("read", motion=self._motion, **{"from": 0})
            with self._understood("read"):
                x = float(reply["position"])
            if abs(x) <= rig_motion.RETURNED:
                return
            speed = min(RETURN_SPEED, 0.5 * self._limits.speed)
            moves = Limits(speed=speed, acceleration=1.0, rate=1.0 / self.T_s)
            velocity = np.append(approach(moves, -x), np.zeros(round(DWELL / self.T_s)))
            try:
                loop = self.loop.changed(K_x=K_X)
            except ControlError as fault:
                raise RigError(f"{self.name}: no loop for moves back to 0 ({fault})") from fault
            low, high = self._limits.travel
            room = min(low, x - MARGIN), max(high, x + MARGIN)
            back = Command(self.T_s, loop, velocity=velocity)
            self._run(back, replace(self._limits, travel=room))
        raise RigError(
            f"{self.name}: the drive does not return to where motions begin; it stands at {x:.4g} m"
        )

    def _run(self, command: Command, limits: RigLimits) -> Log:
        """Load a motion, start it, and read its log until the drive is at rest."""
        signals, n = command.signals, len(command)
        self._number += 1  # also after a motion that was refused
        motion, before = self._number, self._motion
        begin = 0
        while begin < n:
            part = {name: one[begin : begin + CHUNK].tolist() for name, one in signals.items()}
            values = {"from": begin, "values": part}
            reply = self._request("load", motion=motion, **values)
            with self._understood("load"):
                if int(reply["loaded"]) <= begin:
                    raise ValueError(f"loaded {reply['loaded']}, after {begin}")
                begin = int(reply["loaded"])
        loop = {name: getattr(command.loop, name) for name in LOOP}
        x: list[float] = []
        F: list[float] = []
        try:
            self._motion = motion
            start = {"samples": n, "crc": crc_of(signals), "loop": loop}
            start["limits"] = sent_limits(asdict(limits))
            try:
                self._request("start", motion=motion, **start)
            except Refusal:
                self._motion = before
                raise
            moved = time.monotonic()
            while True:
                reply = self._request("read", motion=motion, **{"from": len(x)})
                with self._understood("read"):
                    new, state = reply["values"], str(reply["state"])
                    limit, reason = bool(reply["limit"]), str(reply["reason"])
                    x += map(float, new["x_enc"])
                    F += map(float, new["F_m"])
                    complete = len(x) == len(F) == reply["samples"]
                if new["x_enc"]:
                    moved = time.monotonic()
                if time.monotonic() - moved > (stall := rig_motion.STALL):
                    state, limit = "aborted", False
                    reason = f"{len(x)} samples arrived, and none for {stall:g} s; look at it"
                    self._stop(motion)
                    break
                if complete:
                    if state in ("done", "aborted"):
                        break
                    time.sleep(min(0.02, 0.1 * self._heartbeat))
        except BaseException:
            self._stop(motion)
            raise
        if state == "aborted" or len(x) != n:
            kind = LimitError if limit else RigError
            raise kind(f"{self.name}: motion {motion} of {n * self.T_s:.4g} s: {reason}")
        return Log(np.asarray(np.arange(n) * self.T_s), np.array(x), np.array(F))

    def _stop(self, motion: int) -> None:
        """Stop the drive, if it can still be told; else it stops without heartbeat."""
        self._patience, patience = min(self._patience, 1.0), self._patience
        with suppress(RigError):
            self._request("stop", motion=motion)
        self._patience = patience

    def _request(self, what: str, **fields: Any) -> dict[str, Any]:
        """Send a request until it is answered, over a new connection if need be; raise RigError."""
        first, why = self._seq + 1, "it does not answer"
        give_up = time.monotonic() + self._patience
        while time.monotonic() < give_up:
            try:
                reply = self._exchange(what, fields, first)
            except (OSError, ValueError) as fault:
                self._disconnect()
                why = str(fault)
                time.sleep(min(self._retry, 0.05))
                continue
            if reply is None:
                continue
            with self._understood(what):
                self._heard = max(self._heard, float(reply["clock"]))
            if "error" in reply:
                why = " ".join(str(reply["error"]).split())
                raise Refusal(f"{self.name} refuses to {what}: {why}")
            return reply
        raise RigError(
            f"{self.name}: connection lost for {self._patience:g} s ({why}); the drive stops by "
            "itself. Look at it before going on: a motion is not repeated"
        )

    def _exchange(self, what: str, fields: dict[str, Any], first: int) -> dict[str, Any] | None:
        """Send a request once and wait for an answer to it, also to one sent before."""
        if self._socket is None:
            self._socket = socket.create_connection(self._place, self._patience)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._lines = Lines()
        self._seq += 1
        message = {"seq": self._seq, "session": self._session, "do": what, "heard": self._heard}
        self._socket.settimeout(self._retry)
        self._socket.sendall(line_of({**message, **fields}))
        give_up = time.monotonic() + self._retry
        while (left := give_up - time.monotonic()) > 0.0:
            self._socket.settimeout(left)
            try:
                received = self._socket.recv(65536)
            except TimeoutError:
                return None
            if not received:
                raise OSError("the connection was closed")
            for reply in self._lines.messages(received):
                if isinstance(reply.get("seq"), int) and first <= reply["seq"] <= self._seq:
                    return reply
        return None

    def _disconnect(self) -> None:
        """Close the connection, if there is one."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    @contextmanager
    def _understood(self, what: str) -> Iterator[None]:
        """Raise a RigError where what an answer should contain is missing or is something else."""
        try:
            yield
        except (LookupError, TypeError, ValueError, OverflowError) as fault:
            raise RigError(
                f"{self.name}: its answer to '{what}' is not of protocol {PROTOCOL}: "
                f"{type(fault).__name__} {fault}"
            ) from None
