"""Inputs and tables."""
