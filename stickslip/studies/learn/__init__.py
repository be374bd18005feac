"""``stickslip learn``: a compensator from a log, or on a rig."""
