"""Commands that are no study: one per file, see ``stickslip/commandline``."""

from stickslip.fmi.additions import own_folder

__path__.append(str(own_folder() / "commands"))
