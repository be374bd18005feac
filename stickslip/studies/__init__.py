"""What users run, each a folder: its run, its result, its page and its command."""
