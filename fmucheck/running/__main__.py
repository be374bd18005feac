"""``python -m fmucheck.running JOB REPORT``: a child process."""

import sys

from fmucheck.running.child import main

main(*sys.argv[1:])
