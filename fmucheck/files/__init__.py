"""The other files of an FMU: sources, terminals, icons, documentation."""
