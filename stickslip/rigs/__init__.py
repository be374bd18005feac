"""Rigs: real or simulated drives that run commands and return logs."""
