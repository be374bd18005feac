"""How fast learning learns, and what a candidate costs: ``python -m benchmarks speed``."""
