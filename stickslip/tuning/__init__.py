"""Learning on the drive, and the refinement after it."""
