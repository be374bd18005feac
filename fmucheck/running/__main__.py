"""``python -m stickslip.fmucheck.running JOB REPORT``: a child process."""

import sys

from stickslip.fmucheck.running.child import main

main(*sys.argv[1:])
