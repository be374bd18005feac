"""Inputs that are wrong: malformed files, seeded defects, fuzzers and survival trials."""
