"""A controller with the function block StickslipRig, interpreted, on a drive FMU, behind ADS."""

import itertools
import math
import os
import re
import struct
import threading
import time
from contextlib import contextmanager

from pyads.testserver import AdsTestServer, AdvancedHandler
from pyads.testserver.handler import AmsResponseData

from stickslip.rigs.ads_rig import CODE
from stickslip.rigs.served_drive import stepped
from tests.models.firmware import structured_text

F_MAX = 205.0
NUMBERS = itertools.count(1)


class Place:
    """Where a variable of the function block is; its value are the bytes that ADS carries."""

    def __init__(self, controller, name, handle):
        base, index = re.fullmatch(r"MAIN\.rig\.(\w+)(?:\[(\d+)\])?", name.strip("\0")).groups()
        self._lock, self._scope, self.handle = controller.lock, controller.block.variables, handle
        self._holder, self._key = self._scope, base
        if index is not None:
            self._holder, self._key = self._scope[base], int(index)
        _ = self._holder[self._key]

    @property
    def _format(self):
        value = self._holder[self._key]
        return f"<{len(value)}d" if isinstance(value, list) else self._one(value)

    @staticmethod
    def _one(value):
        return {bool: "<?", int: "<i", float: "<d"}[type(value)]

    @property
    def value(self):
        with self._lock:
            value = self._holder[self._key]
            return struct.pack(self._format, *(value if isinstance(value, list) else [value]))

    def write(self, value, _request=None):
        with self._lock:
            new = struct.unpack(self._format, value)
            kept = self._holder[self._key]
            self._holder[self._key] = list(new) if isinstance(kept, list) else new[0]


class Controller(AdvancedHandler):
    """Calls the function block each T_s, while ``running``; a brake holds an axis not enabled."""

    def __init__(self, fmus, T_s, heartbeat):
        super().__init__()
        code = CODE.read_text().replace("0..499", "0..19").replace("200000", "8000")
        self.block = structured_text.load(code)["StickslipRig"]
        self.drive = stepped(fmus / "drive.fmu", T_s, ["u"], ["x_enc", "F_m"])
        self.measured = list(self.drive.start().values())
        self.inputs = {"T_s": T_s, "F_max": F_MAX, "heartbeat": heartbeat, "ready": True}
        self.running, self.period = True, T_s
        self.silent_from = math.inf  # samples of a motion
        self.lock, self._places = threading.RLock(), []

    def __getitem__(self, name):
        return self.block.variables[name]

    def cycle(self):
        with self.lock:
            x, F = self.measured
            self.block(x_enc=x, F_m=F, **self.inputs)
            if self["enable"]:
                self.measured = list(self.drive.step({"u": self["F"]}).values())

    def run(self, end):
        due = time.monotonic()
        while not end.is_set():
            if self.running:
                self.cycle()
            due = max(due + self.period, time.monotonic() + 5e-5)
            time.sleep(max(0.0, due - time.monotonic()))

    def get_variable_by_name(self, name):
        with self.lock:
            self._places.append(Place(self, name, len(self._places) + 1))
            return self._places[-1]

    def get_variable_by_handle(self, handle):
        return self._places[handle - 1]

    def handle_request(self, request):
        if self["k"] >= self.silent_from:
            return None
        try:
            return super().handle_request(request)
        except (LookupError, AttributeError):
            flags = struct.unpack("<H", request.ams_header.state_flags)[0] | 1
            failed = struct.pack("<II", 0x710, 0)  # symbol not found
            return AmsResponseData(struct.pack("<H", flags), b"\0" * 4, failed)


@contextmanager
def controller(fmus, T_s, heartbeat=0.5):
    """Return a controller that runs, and its address; each has its own, as ADS has one port."""
    pid = os.getpid()
    ip = f"127.{pid >> 8 & 255}.{pid & 255}.{next(NUMBERS)}"
    found, end = Controller(fmus, T_s, heartbeat), threading.Event()
    thread = threading.Thread(target=found.run, args=(end,))
    with AdsTestServer(found, ip_address=ip, logging=False):
        thread.start()
        try:
            yield found, ip
        finally:
            end.set()
            thread.join()
            found.drive.close()
