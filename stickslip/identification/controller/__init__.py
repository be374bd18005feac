"""The controller of a log: its form, its initial state, and what it allows."""
