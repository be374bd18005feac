"""The zip archive: read without trusting it, unpacked without leaving its folder."""
