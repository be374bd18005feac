"""FMUs in a child process, whose crash does not end the caller.

Requests are pickles. Answers are JSON, so that nothing from the child is executed.
"""
