"""Metrics, validation and comparisons."""
