"""Loops with other gains or compensators than the present one, on the drives of a log."""
