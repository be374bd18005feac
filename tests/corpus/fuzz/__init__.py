"""Feeds mutated inputs to everything that reads what strangers wrote."""
