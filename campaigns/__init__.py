"""What measures or searches for hours and is run by name; of some, tests run a short version."""
