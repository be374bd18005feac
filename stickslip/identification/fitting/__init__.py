"""Least squares, starts, bootstrap and identifiability."""
