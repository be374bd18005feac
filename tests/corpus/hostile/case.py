"""A hostile input: how it is made, and what is said of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

Content = bytes | str | Callable[[Path], object]
"""What a file holds, or what makes it: given its path, it writes there or returns the content."""


@dataclass(frozen=True)
class Case:
    """One row of the table."""

    group: int  # what it attacks, a key of `GROUPS`
    name: str  # of its own
    about: str  # what is hostile about it, for the table
    says: str  # regular expression that the line matches which the command ends with
    command: str  # arguments of ``stickslip``, run in a folder that holds the files
    files: Mapping[str, Content] = field(default_factory=dict)  # by name, written in this order
    code: str = ""  # Python that is run there instead of a command, see ``python.run``

    def make(self, folder: Path) -> list[str]:
        """Write the files; return the arguments."""
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            made = content(path) if callable(content) else content
            if isinstance(made, str | bytes):
                path.write_bytes(made.encode() if isinstance(made, str) else made)
        return self.command.split()

    def __str__(self) -> str:
        return f"{self.group}-{self.name}"


def family(
    group: int, prefix: str, command: str, *, file: str = "", begins: str = "", **others: Content
) -> Callable[..., Case]:
    """Return what makes the cases of one command, each with another content of one file.

    Without its name the content is the rest of the command; a {} in both stands for the suffix.
    ``begins`` is what each message begins with. In names of others ``_`` stands for the dot.
    """

    def case(
        name: str,
        about: str,
        says: str,
        content: Content | None,
        suffix: str = ".csv",
        more: str = "",
    ) -> Case:
        files = {other.replace("_", "."): text for other, text in others.items()}
        if file and content is not None:
            files[file.format(suffix)] = content
        whole = f"{command.format(suffix)} {more if file else content}".strip()
        return Case(group, f"{prefix}-{name}", about, begins + says, whole, files)

    return case


GROUPS = {
    1: "names of members",
    2: "links",
    3: "archives that grow",
    4: "damaged archives",
    5: "the description as a file",
    6: "XML that attacks its reader",
    7: "versions of FMI",
    8: "names and references of variables",
    9: "references inside the description",
    10: "identifiers as paths",
    11: "numbers of the description",
    12: "dimensions of arrays",
    13: "characters in names",
    14: "binaries that do not load",
    15: "instances refused",
    16: "binaries that attack their process",
    17: "statuses",
    18: "values",
    19: "states that are not restored",
    20: "numbers of instances",
    21: "systems",
    22: "tables of inputs and logs",
    23: "learning",
    24: "rigs",
    25: "arena",
    26: "arguments in Python",
    27: "values on the command line",
    28: "exports",
    29: "the sandbox",
    30: "clusters and consoles",
}
"""What a case attacks."""


def python(group: int, name: str, about: str, says: str, code: str, **others: Content) -> Case:
    """Return a case of Python; what others hold is as of ``family``."""
    files = {other.replace("_", "."): text for other, text in others.items()}
    return Case(group, name, about, says, "", files, code)
