"""Metrics, validation, guards and comparisons."""
