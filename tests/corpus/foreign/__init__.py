"""FMUs and packages of other tools: each is run here and in FMPy, and the outputs are compared."""
