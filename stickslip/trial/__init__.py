"""Compensators tried on simulated drives that a log supports, before one is written."""
