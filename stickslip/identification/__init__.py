"""Parameters of a drive: the three stages of the paper, and the estimation from one log."""
