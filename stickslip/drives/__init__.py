"""Drives by their parameters: published ones, and what simulators of robots take of them."""
