"""What is wrong with an archive."""


class Refused(Exception):
    """An archive that is not unpacked; the message lacks its path, which the caller knows."""
