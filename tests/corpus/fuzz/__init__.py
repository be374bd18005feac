"""Feeds mutated inputs to everything that reads files of others."""

from tests.corpus.fuzz import formats, texts

PARSERS = texts.PARSERS | formats.PARSERS
