"""Ctrl-C is tested, too: a process that was started in the background, or by xdist, ignores it."""

import signal

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
