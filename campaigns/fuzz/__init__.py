"""Feeds mutated inputs to everything that reads files of others."""

from campaigns.fuzz import formats, texts

PARSERS = texts.PARSERS | formats.PARSERS
