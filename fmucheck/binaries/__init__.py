"""Shared libraries of every platform, read without loading them."""
