"""learned.json and the folders of results."""
