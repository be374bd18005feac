"""Inputs, tables and scenarios."""
