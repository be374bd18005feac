"""The base of all errors that a user can cause."""


class Fault(Exception):
    """What a user can cause, in any package; the command line prints its message in one line."""
