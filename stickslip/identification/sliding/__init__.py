"""Mass, offset and friction against speed from sliding motion, without a friction law."""
