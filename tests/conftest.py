"""Settings of all tests.

Tests interrupt runs with Ctrl-C, which a process started in the background, or by xdist, ignores.
A busy machine may take any time for one example of Hypothesis, so examples have no deadline.
"""

import signal

from hypothesis import settings

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("stickslip", deadline=None)
settings.load_profile("stickslip")
