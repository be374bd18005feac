"""Untrusted zip archives: checked before anything is written, unpacked once.

``names`` says which names members may have, ``directory`` whether what the archive says of itself
can be true; ``members`` writes one after another, every byte counted; ``unpacked`` is the cache.
"""

from stickslip.fmi.archive.unpacked import restore, unpack

__all__ = ["restore", "unpack"]
