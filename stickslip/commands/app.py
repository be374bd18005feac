"""``stickslip app``: open the workbench in the browser.

stickslip app results
"""

import argparse
import webbrowser
from pathlib import Path

from stickslip.commandline import FLAG, add_options
from stickslip.errors import UsageError, name_settings
from stickslip.fmi.messages import installing
from stickslip.output import Answer


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Serve the workbench to the browser of this machine, at 127.0.0.1 and with a token that is "
        "new each time. Ctrl-C ends it. Needs the extra app."
    )
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        default=Path(),
        help="of logs, FMUs and systems; results are written to FOLDER/runs (default: this one)",
    )
    add_options(parser, {"--port N": "port (default: a free one)"}, type=int, default=0)
    add_options(parser, {"--no-browser": "only print the address"}, **FLAG)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Serve until Ctrl-C."""
    if not options.folder.is_dir():
        raise UsageError(f"{options.folder}: expected a folder; create it first")
    if not 0 <= options.port < 2**16:
        raise UsageError(f"--port {options.port}: expected 0 to 65535")
    try:
        from stickslip.app.server import serve  # late: loads a web server
    except ModuleNotFoundError as missing:
        how = f"the workbench needs {missing.name}; run: {installing('app')}"
        raise UsageError(how) from None

    def announce(address: str) -> None:
        print(f"the workbench of {options.folder}, until Ctrl-C ends it: {address}", flush=True)
        if not options.no_browser:
            webbrowser.open(address)

    name_settings("fields")
    try:
        serve(options.folder.resolve(), options.port, announce)
    except OSError as fault:
        raise UsageError(f"--port {options.port}: {fault.strerror}") from None
    return Answer()
