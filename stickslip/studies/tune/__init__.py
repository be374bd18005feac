"""Tuning of a loop: on the drives that a log supports, or of any system of FMUs by a cost file."""
