"""FMUs: files, variables, binaries and their states."""
