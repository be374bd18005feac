"""Prepare, step, record and save runs."""
