"""Models stepped in lanes: several instances at once, each with the bits of its FMU."""
