"""learned.json: what every study reads of a learned drive."""
