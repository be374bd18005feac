"""Parameters: names, units, the values of the paper, and the coordinates of an estimation."""
