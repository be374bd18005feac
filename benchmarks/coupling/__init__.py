"""The ring of three FMUs: cosim and C loops."""
