"""Parameters: names, units and the values of the paper."""
