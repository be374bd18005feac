"""Turns a model's folder into FMUs of FMI 2.0 and FMI 3.0."""
