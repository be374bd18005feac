"""Evaluation of candidates, and the learning loop."""
