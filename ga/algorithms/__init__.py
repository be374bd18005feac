"""Optimisers behind one interface."""
