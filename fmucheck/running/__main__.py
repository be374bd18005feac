"""``python -m stickslip.fmucheck.running JOB REPORT``: a child process."""

import os
import sys

from stickslip.fmucheck.running.child import main

sys.stdout.flush()
os.ftruncate(1, 0)  # what Python printed as it started is not the FMU's
os.lseek(1, 0, os.SEEK_SET)
main(*sys.argv[1:])
