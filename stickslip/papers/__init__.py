"""Publications that are reproduced, each a folder."""
