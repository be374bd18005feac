"""FMUs and packages of a folder: each is run here, and in FMPy, and the outputs are compared."""
