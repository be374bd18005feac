"""A served drive behind a socket: what ``stickslip serve`` runs. The protocol: docs/rig.md."""

import selectors
import socket
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, cast

import numpy as np

from stickslip.cosim import CosimError
from stickslip.errors import UsageError
from stickslip.fmi.process import check_interruption
from stickslip.rigs.lines import CHUNK, LOOP, PROTOCOL, Lines, crc_of, line_of, received_limits
from stickslip.rigs.served_drive import ServedDrive

BURST = 100  # most samples between two looks at the sockets
MOST = 2_000_000  # most samples of a motion
SEND_BUFFER = 1 << 18  # bytes of answers kept for a connection, several of the longest
SIGNALS = ("F", "F_ff", "a_cmd", "v_cmd", "x_cmd")


class Refusal(Exception):
    """A request that is answered with an error."""


class Server:
    """Listens, answers requests, and runs the drive meanwhile."""

    def __init__(
        self,
        drive: ServedDrive,
        address: tuple[str, int],  # host and port to listen at; port 0 takes a free one
        name: str,
        *,
        heartbeat: float = 0.5,  # a motion is aborted after so long without a request [s]
        fast: bool = False,  # whether the drive runs as fast as possible instead of in real time
    ) -> None:
        self._drive, self._name, self._heartbeat, self._fast = drive, name, heartbeat, fast
        self._session, self._lease = "", 0.0
        self._loading, self._loaded = 0, dict[str, list[float]]()
        self._selector = selectors.DefaultSelector()
        self._listener = socket.create_server(address)
        self._listener.setblocking(False)
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._due = self.late = 0.0

    @property
    def port(self) -> int:
        """The port that it listens at."""
        return int(self._listener.getsockname()[1])

    def serve(self, until: Callable[[], bool] = lambda: False) -> None:
        """Answer and run until Ctrl-C, or until a function says so."""
        try:
            while not until():
                check_interruption()
                self._answer_all(self._run_drive())
        finally:
            self._drive.abort("the server was stopped")
            for key in list(self._selector.get_map().values()):
                key.fileobj.close()  # type: ignore[union-attr]
            self._selector.close()

    def _run_drive(self) -> float:
        """Run the samples that are due; return how long to wait for requests [s]."""
        drive = self._drive
        if drive.state == "idle":
            return 0.1
        now = time.monotonic()
        if drive.state == "moving" and now > self._lease:
            t = len(drive.x) * drive.T_s
            drive.abort(f"aborted at {t:.4g} s: no heartbeat for {self._heartbeat:g} s")
        self.late = max(self.late, 0.0 if self._fast else now - self._due)
        for _ in range(BURST):
            if drive.state == "idle" or not (self._fast or self._due <= now):
                break
            drive.advance()
            self._due += drive.T_s
        return 0.0 if self._fast else max(0.0, min(self._due - time.monotonic(), 0.01))

    def _answer_all(self, wait: float) -> None:
        for key, _ in self._selector.select(wait):
            self._run_drive()  # many clients do not keep it waiting
            if key.fileobj is self._listener:
                with suppress(OSError):  # it does not wait any more
                    connection, _ = self._listener.accept()
                    connection.setblocking(False)  # who does not read answers is not waited for
                    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
                    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    self._selector.register(connection, selectors.EVENT_READ, Lines())
                continue
            connection = cast("socket.socket", key.fileobj)
            try:
                received = connection.recv(65536)
                for message in key.data.messages(received):
                    connection.sendall(line_of(self._answer(message)))
                if received:
                    continue
            except (OSError, ValueError):
                pass  # lost, not read at the other end, or not of this protocol
            self._selector.unregister(connection)
            connection.close()

    def _answer(self, message: Mapping[str, Any]) -> dict[str, Any]:
        found: dict[str, Any] = {"seq": message.get("seq")}
        try:
            found |= self._do(message)
        except Refusal as refusal:
            found["error"] = str(refusal)
        except (KeyError, TypeError, ValueError, OverflowError) as fault:
            found["error"] = f"not a request of protocol {PROTOCOL}: {type(fault).__name__} {fault}"
        found |= {"clock": time.monotonic(), "position": self._drive.position}
        return found

    def _do(self, message: Mapping[str, Any]) -> dict[str, Any]:
        what, session = message["do"], str(message["session"])
        if what == "hello":
            return self._hello(session, message["protocol"])
        if session != self._session:
            raise Refusal("another program has taken the drive, or the server was started again")
        heard, now = float(message["heard"]), time.monotonic()
        if heard <= now:
            self._lease = max(self._lease, heard + self._heartbeat)
        motion = int(message["motion"])
        handlers = {"load": self._load, "start": self._start, "read": self._read, "stop": self._end}
        if what not in handlers:
            raise Refusal(f"cannot {what!r}; expected hello, load, start, read or stop")
        return handlers[what](motion, message)

    def _hello(self, session: str, protocol: object) -> dict[str, Any]:
        if protocol != PROTOCOL:
            raise Refusal(f"protocol {protocol}; expected {PROTOCOL}")
        if session != self._session and self._drive.state != "idle":
            raise Refusal("the drive moves for another program")
        self._session = session
        return {
            "protocol": PROTOCOL,
            "name": self._name,
            "T_s": self._drive.T_s,
            "heartbeat": self._heartbeat,
            "last": self._drive.motion,
        }

    def _load(self, motion: int, message: Mapping[str, Any]) -> dict[str, Any]:
        """Take samples of a motion to come; those that are here already are passed over."""
        if motion <= self._drive.motion:
            raise Refusal(f"motion {motion} has been started; the next is {self._drive.motion + 1}")
        if motion != self._loading:
            self._loading, self._loaded = motion, {}
        begin, values = int(message["from"]), dict(message["values"])
        for name in values:
            if name not in SIGNALS:
                raise Refusal(f"no signal {name!r}; expected {', '.join(SIGNALS)}")
        for name, samples in values.items():
            kept = self._loaded.setdefault(name, [])
            if begin > len(kept):
                raise Refusal(f"{name} from sample {begin}; expected from {len(kept)}")
            new = [float(value) for value in samples[len(kept) - begin :]]
            if len(kept) + len(new) > MOST or not np.isfinite(new).all():
                raise Refusal(f"{name}: expected at most {MOST} finite values")
            kept += new
        return {"loaded": min(map(len, self._loaded.values()), default=0)}

    def _start(self, motion: int, message: Mapping[str, Any]) -> dict[str, Any]:
        """Start a motion once; a doubled request finds it started."""
        drive = self._drive
        if motion == drive.motion:
            return {"state": self._state}
        if motion < drive.motion or motion != self._loading:
            raise Refusal(f"motion {motion} is not loaded, or is past")
        if drive.state != "idle" or drive.failed:
            raise Refusal(drive.failed or f"motion {drive.motion} still runs")
        if time.monotonic() > self._lease:
            raise Refusal(f"motion {motion}: the request is older than {self._heartbeat:g} s")
        signals = {name: np.array(values) for name, values in self._loaded.items()}
        whole = {len(values) for values in signals.values()} == {int(message["samples"])}
        if not whole or not message["samples"] or crc_of(signals) != message["crc"]:
            raise Refusal(f"motion {motion}: what was loaded is not what was sent; send it again")
        if ("F" in signals) == ("v_cmd" in signals):
            raise Refusal(f"motion {motion}: expected F or v_cmd")
        loop = {name: float(message["loop"][name]) for name in LOOP}
        try:
            checked = received_limits(message["limits"])
        except UsageError as fault:
            raise Refusal(str(fault)) from None
        try:
            drive.start(motion, signals, loop, checked)
        except CosimError as fault:
            raise Refusal(f"motion {motion}: the controller refuses its loop: {fault}") from None
        self._loaded, self._due, self.late = {}, time.monotonic(), 0.0
        return {"state": self._state}

    def _read(self, motion: int, message: Mapping[str, Any]) -> dict[str, Any]:
        drive = self._drive
        if motion != drive.motion:
            raise Refusal(f"motion {motion} is not the last; that is {drive.motion}")
        begin = int(message["from"])
        end = begin + CHUNK
        return {
            "state": self._state,
            "reason": drive.reason,
            "limit": drive.at_limit,
            "samples": len(drive.x),
            "late": round(self.late, 6),
            "values": {"x_enc": drive.x[begin:end], "F_m": drive.F[begin:end]},
        }

    def _end(self, motion: int, _: Mapping[str, Any]) -> dict[str, Any]:
        if motion == self._drive.motion:
            self._drive.abort("stopped by the program")
        return {"state": self._state}

    @property
    def _state(self) -> str:
        """The state of the last motion: moving, stopping, done or aborted."""
        drive = self._drive
        if drive.state != "idle":
            return drive.state
        return "aborted" if drive.reason else "done"
