"""A drive learned behind a socket, within limits.

    stickslip build drive --out fmus
    stickslip serve fmus/fmi2/drive.fmu &
    python examples/real_drive.py [HOST:PORT]

Each log is kept in drive_1/motions: started again after an interruption, the program goes on there.
"""

import sys

import stickslip as ss

limits = ss.RigLimits(travel=(-0.12, 0.12), speed=0.2, force=120.0, following_error=2e-3)
sheet = ss.Datasheet(mass=5.5, peak_force=205.0, encoder_step=4e-7)
with ss.SocketRig(*sys.argv[1:] or ["localhost:5020"], sheet, limits) as drive:
    rig = ss.KeptRig(drive, "drive_1/motions")
    learned = ss.learn(rig, limits=ss.Limits(stroke=0.1, speed=0.04, acceleration=2.0))
    ss.write_learned(learned, "drive_1/learned")
    print(ss.validate(rig, learned))
