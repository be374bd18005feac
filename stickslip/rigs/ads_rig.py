"""A rig behind a Beckhoff controller, over ADS; plc/StickslipRig.st runs the motions there."""

import math
import re
import secrets
import socket
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from stickslip.errors import RigError, UsageError
from stickslip.fmi.messages import installing
from stickslip.rigs.contract import Command, Log
from stickslip.rigs.limits import RigLimits, Watch
from stickslip.rigs.remote import Refusal, RemoteRig
from stickslip.servo.axis import Datasheet
from stickslip.thresholds import rig_motion

CODE = Path(__file__).with_name("plc") / "StickslipRig.st"
BLOCK = 400  # samples in one array of the function block
SIGNALS = ("v_cmd", "a_cmd", "x_cmd", "F_ff")
WHOLE = (
    *("session", "asker", "asked", "stop", "n", "span", "protocol", "most"),
    *("answered", "refusal", "motion", "state", "k", "fault"),
)
REFUSALS = {
    1: "a motion still runs",
    2: "the controller says that the axis is not ready",
    3: "another program has taken the drive",
    4: "the request is older than the heartbeat time",
    5: "the motion is longer than the arrays of StickslipRig",
}
TCP = 48898  # port of an ADS router
ANSWER = 1.0  # within which a controller that runs the function block answers a start [s]


class AdsRig(RemoteRig):
    """A drive behind a Beckhoff controller that runs the function block ``StickslipRig``.

    ``stickslip export rig`` writes the function block. A motion is started once, whatever is lost
    or repeated. The drive stops by itself when this program does not ask for the ``heartbeat`` that
    the function block is given.

    Parameters
    ----------
    net_id : AMS net id of the controller, such as "5.12.82.20.1.1"
    datasheet : what is known of the drive
    limits : that abort a motion, there and here
    law : friction law of the compensator
    port : AMS port of the PLC's runtime
    symbol : the instance of the function block
    ip : address of the controller, where it is not the first four numbers of the net id
    patience : how long a lost connection is tried again [s]

    Raises
    ------
    RigError
        When there is no answer, or the controller has no such function block.
    UsageError
        When pyads is not installed, or the net id is not of this form.
    """

    chunk = BLOCK

    def __init__(
        self,
        net_id: str,
        datasheet: Datasheet,
        limits: RigLimits,
        law: str = "lugre",
        *,
        port: int = 851,
        symbol: str = "MAIN.rig",
        ip: str | None = None,
        patience: float = 5.0,
    ) -> None:
        try:
            import pyads
        except ImportError:
            raise UsageError(f"AdsRig needs pyads; run: {installing('ads')}") from None
        if not re.fullmatch(r"\d{1,3}(\.\d{1,3}){5}", net_id, re.ASCII):
            raise UsageError(f"rig {net_id!r}: expected an AMS net id of six numbers, a.b.c.d.e.f")
        self._ads, self._symbol = pyads, symbol
        self._connection = pyads.Connection(net_id, port, ip)
        self._handles: dict[str, int] = {}
        self._session = 1 + secrets.randbelow(2**31 - 1)
        self._at, self._by_force = "", False
        self._watch = Watch(limits, 1.0)  # of the motion that runs
        super().__init__(f"{net_id}:{port} {symbol}", datasheet, limits, law, patience=patience)

    def _run(self, command: Command, limits: RigLimits) -> Log:
        """Run a motion, and check that the function block is called as often as it was told."""
        before, begun = self._clock(), time.monotonic()
        log = super()._run(command, limits)
        shown, took = self._clock() - before, time.monotonic() - begun
        pace = rig_motion.PACE
        if took > rig_motion.PACED and not 1.0 / pace < shown / took < pace:
            raise RigError(
                f"{self.name}: {took:.3g} s took {shown:.3g} s there; expected T_s = {self.T_s:g} "
                "s to be the period in which the PLC calls StickslipRig"
            )
        return log

    def _clock(self) -> float:
        reply = self._request("read", motion=self._motion, **{"from": self._most})
        return float(reply["clock"])

    def _request(self, what: str, **fields: Any) -> dict[str, Any]:
        kinds = {"load": self._load, "start": self._start, "read": self._read, "stop": self._end}
        give_up = time.monotonic() + self._patience
        while True:
            try:
                with self._understood(what):
                    if what == "hello":
                        return self._hello()
                    self._watch_over()
                    return kinds[what](fields)
            except Refusal as refusal:
                raise Refusal(f"{self.name} refuses to {what}: {refusal}") from None
            except (OSError, self._ads.ADSError) as fault:
                why = str(fault).removeprefix("ADSError: ").strip(" .")
                if 0x700 <= (getattr(fault, "err_code", None) or 0) < 0x740:  # of the controller
                    raise Refusal(f"{self.name}.{self._at}: {why}; expected StickslipRig") from None
                self._disconnect()
            if time.monotonic() > give_up:
                raise self._lost(why)
            time.sleep(0.05)

    def _hello(self) -> dict[str, Any]:
        if self._get("state") and self._get("session") != self._session:
            raise Refusal("the drive moves for another program")
        self._put("session", self._session)
        self._most = self._get("most")
        wanted = ("protocol", "T_s", "heartbeat")
        return {name: self._get(name) for name in wanted} | {"last": self._get("answered")}

    def _watch_over(self) -> None:
        """Show that this program watches, by the time of the controller that it read."""
        if self._get("session") != self._session:
            raise Refusal(
                "another program has taken the drive, or the controller was started again"
            )
        self._put("heard", self._get("clock"))

    def _load(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        begin, values = asked["from"], asked["values"]
        self._by_force = "F" in values
        given = {"F_ff": values["F"]} if self._by_force else values
        end = begin + len(next(iter(values.values())))
        if end > self._most:
            raise Refusal(f"{REFUSALS[5]}, {self._most} samples; make them longer there")
        for name in SIGNALS:
            samples = given.get(name, ())
            self._put_block(f"{name}[{begin // BLOCK}]", samples)
        return {"loaded": end}

    def _start(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        motion, loop, limits = asked["motion"], asked["loop"], dict(asked["limits"])
        if not all(0.0 <= gain < math.inf for gain in loop.values()):
            raise Refusal(f"expected gains of 0 or more, got {loop}")
        if self._get("answered") < motion:
            self._watch = Watch(RigLimits(**limits), self.T_s)
            low, high = limits.pop("travel")
            values = {**loop, **limits, "x_low": low, "x_high": high, "asker": self._session}
            values |= {"n": asked["samples"], "by_force": self._by_force, "span": self._watch.span}
            for name, value in values.items():
                self._put(name, value)
            self._put("heard", self._get("clock"))
            self._put("asked", motion)
        give_up = time.monotonic() + ANSWER
        while self._get("answered") < motion:
            if time.monotonic() > give_up:
                raise Refusal(f"StickslipRig was not called for {ANSWER:g} s; is the PLC running?")
            time.sleep(0.005)
        if self._get("motion") != motion:
            raise Refusal(REFUSALS.get(self._get("refusal"), "unknown reason"))
        return {}

    def _read(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        begin, state = asked["from"], self._get("state")  # the state first: at rest, k is final
        fault, value, n = self._get("fault"), self._get("value"), self._get("k")
        new: dict[str, list[float]] = {"x_enc": [], "F_m": []}
        if begin < n:
            block, first = divmod(begin, BLOCK)
            for name, array in (("x_enc", "x_log"), ("F_m", "F_log")):
                new[name] = self._get_block(f"{array}[{block}]")[first : n - block * BLOCK]
        return {
            "state": {1: "moving", 2: "stopping"}.get(state, "aborted" if fault else "done"),
            "limit": fault in (1, 2, 3, 4),
            "reason": f"aborted at {max(0, n - 1) * self.T_s:.4g} s: {self._said(fault, value)}"
            if fault
            else "",
            "samples": n,
            "values": new,
            "position": self._get("x_enc"),
            "clock": self._get("clock"),
        }

    def _said(self, fault: int, value: float) -> str:
        """Return what ended a motion, in words."""
        of_limits = ("position", "speed", "force", "following_error")
        others = {
            5: "position or force is not finite",
            6: f"no heartbeat for {self._heartbeat:g} s",
            7: "stopped by the program",
            8: "the controller says that the axis is not ready",
        }
        if fault <= len(of_limits):
            return self._watch.exceeded(of_limits[fault - 1], value)
        return others[fault]

    def _end(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        self._put("stop", asked["motion"])
        return {}

    def _type(self, name: str) -> Any:
        if name == "by_force":
            return self._ads.PLCTYPE_BOOL
        return self._ads.PLCTYPE_DINT if name in WHOLE else self._ads.PLCTYPE_LREAL

    def _get(self, name: str) -> Any:
        handle = self._handle(name)
        return self._connection.read_by_name("", self._type(name), handle=handle)

    def _put(self, name: str, value: float) -> None:
        handle = self._handle(name)
        self._connection.write_by_name("", value, self._type(name), handle=handle)

    def _get_block(self, name: str) -> list[float]:
        self._at = name
        array = self._ads.PLCTYPE_LREAL * BLOCK
        return list(self._connection.read_by_name(f"{self._symbol}.{name}", array))

    def _put_block(self, name: str, samples: Sequence[float]) -> None:
        self._at = name
        array = self._ads.PLCTYPE_LREAL * BLOCK
        values = [*samples, *[0.0] * (BLOCK - len(samples))]
        self._connection.write_by_name(f"{self._symbol}.{name}", values, array)

    def _handle(self, name: str) -> int:
        """Return the handle of a variable, which stays the same until the connection is lost."""
        self._at = name
        if not self._connection.is_open:
            if sys.platform != "win32":  # ADS itself waits for minutes
                place = self._connection.ip_address, TCP
                socket.create_connection(place, self._patience).close()
            self._connection.open()
            self._connection.set_timeout(round(1000 * min(self._patience, 1.0)))
        if name not in self._handles:
            self._handles[name] = self._connection.get_handle(f"{self._symbol}.{name}")
        return self._handles[name]

    def _disconnect(self) -> None:
        if self._connection.is_open:
            for handle in self._handles.values():
                with suppress(self._ads.ADSError):
                    self._connection.release_handle(handle)
            with suppress(self._ads.ADSError):
                self._connection.close()
        self._handles = {}
