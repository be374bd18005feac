"""The axis, its velocity loop and filter, and the loops as systems of FMUs.

ControlError(ValueError)         no controller meets the specification
"""
