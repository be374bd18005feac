"""What FMPy does with the malformed inputs of ``tests/corpus/hostile``."""
