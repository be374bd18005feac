"""The binary at work: driven by raw calls in a child process, which may crash without harm."""
