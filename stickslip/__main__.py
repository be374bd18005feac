"""``python -m stickslip``, and the command ``stickslip``."""

import os
import signal
import sys
from types import FrameType


def main() -> int:
    """Run the command line; a signal is one line even while its modules are imported."""
    numbers = [
        number
        for name in ("SIGINT", "SIGTERM", "SIGHUP")
        if (number := getattr(signal, name, None))
        and signal.getsignal(number) in (signal.default_int_handler, signal.SIG_DFL)
    ]
    for number in numbers:
        signal.signal(number, _leave)
    # One thread, so that results do not depend on how many the linear algebra would take.
    os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("BLIS", "MKL", "OPENBLAS")}
    from stickslip import cli

    status = cli.main()
    for number in numbers:
        signal.signal(number, signal.SIG_IGN)  # all is done, and only the interpreter is left
    return status


def _leave(number: int, _: FrameType | None) -> None:
    os.write(2, b"stickslip: interrupted\n")
    os._exit(128 + number)


if __name__ == "__main__":
    sys.exit(main())
