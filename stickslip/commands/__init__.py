"""Commands that are no study: one per file, see ``stickslip/commandline``."""
