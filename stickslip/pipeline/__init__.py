"""From experiment to result, for each mode of the application."""
