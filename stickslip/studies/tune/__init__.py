"""Tuning of a loop: on the drives that a log supports, or of any system of FMUs by a cost file."""

MOTIONS = 12  # of a rig, at most
