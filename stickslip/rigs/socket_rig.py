"""A rig in another process, behind a socket: the protocol is in docs/rig.md."""

import secrets
import socket
import time
from typing import Any

from stickslip.errors import UsageError
from stickslip.rigs.limits import RigLimits
from stickslip.rigs.lines import Lines, line_of, sent_limits
from stickslip.rigs.remote import Refusal, RemoteRig
from stickslip.servo.axis import Datasheet


class SocketRig(RemoteRig):
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
        super().__init__(address, datasheet, limits, law, patience=patience)

    def _request(self, what: str, **fields: Any) -> dict[str, Any]:
        if "limits" in fields:
            fields["limits"] = sent_limits(fields["limits"])
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
        raise self._lost(why)

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
                    found = reply
                    break
            else:
                continue
            return found
        return None

    def _disconnect(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None
