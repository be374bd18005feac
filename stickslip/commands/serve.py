"""``stickslip serve``: run a drive FMU as a drive behind a socket.

stickslip serve drive.fmu --port 5000
"""

import argparse
from pathlib import Path

from stickslip.commandline import FLAG, add_options
from stickslip.errors import UsageError
from stickslip.fmi.process import temporary_folder
from stickslip.output import Answer


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Run a drive FMU with a velocity controller as a drive that stands where its last motion "
        "ended. Connect to it with ss.SocketRig; the protocol is in docs/rig.md. Ctrl-C ends it."
    )
    parser.add_argument("drive", metavar="DRIVE.fmu", type=Path)
    host = {"--host NAME": "address to listen at (default localhost)"}
    add_options(parser, host, default="localhost")
    add_options(parser, {"--port N": "port (default 5020; 0: a free one)"}, type=int, default=5020)
    rate = {"--rate HZ": "samples per second (default 2000)"}
    add_options(parser, rate, type=float, default=2000.0)
    heartbeat = "a motion is aborted when nobody asks for so long (default 0.5)"
    add_options(parser, {"--heartbeat S": heartbeat}, type=float, default=0.5)
    add_options(parser, {"--fast": "run as fast as possible instead of in real time"}, **FLAG)
    for option, name, text in (
        ("--input NAME", "u", "force command [N]"),
        ("--position NAME", "x_enc", "position shown by the encoder [m]"),
        ("--force NAME", "F_m", "motor force [N]"),
    ):
        add_options(parser, {option: f"the FMU's {text} (default {name})"}, default=name)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Build the controller, and serve until Ctrl-C."""
    from stickslip.models import build_fmu  # late: loads compilers and FMUs
    from stickslip.rigs.served_drive import Ports, ServedDrive
    from stickslip.rigs.server import Server

    for name in ("rate", "heartbeat"):
        if not 0.0 < getattr(options, name) < 1e6:
            got = getattr(options, name)
            raise UsageError(f"--{name} {got}: expected more than 0 and less than 1e6")
    if not 0 <= options.port < 2**16:
        raise UsageError(f"--port {options.port}: expected 0 to 65535")
    ports = Ports(options.input, options.position, options.force)
    with temporary_folder() as folder:
        build_fmu("velocity_controller", folder)
        controller = folder / "velocity_controller.fmu"
        drive = ServedDrive(options.drive, controller, 1.0 / options.rate, ports)
        try:
            address = (options.host, options.port)
            server = Server(
                drive, address, options.drive.name, heartbeat=options.heartbeat, fast=options.fast
            )
        except OSError as fault:
            raise UsageError(f"--port {options.port}: {fault.strerror}") from None
        print(f"{options.drive} is served at {options.host}:{server.port}", flush=True)
        try:
            server.serve()
        finally:
            drive.close()
    return Answer()
