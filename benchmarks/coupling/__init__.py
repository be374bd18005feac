"""The ring of three FMUs: cosim, C loops and every peer that pip installs."""
