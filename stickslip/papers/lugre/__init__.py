"""The paper's identification, learning and validation, on a simulated drive of its Table 2."""
