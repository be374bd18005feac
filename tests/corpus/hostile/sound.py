"""Sound FMUs to spoil: the reference FMU of ``tests/corpus/defects``, and packages around it."""

from collections.abc import Callable, Sequence
from pathlib import Path

from tests.corpus.defects import reference
from tests.corpus.hostile.case import Case
from tests.corpus.hostile.zips import DEFLATE, Member, zipped

DESCRIPTION = "modelDescription.xml"


def members(version: int = 2, without: Sequence[str] = ()) -> list[Member]:
    """Return the members of a sound FMU, but for some."""
    content = reference.members(version)
    needed = (DESCRIPTION, reference.binary_name(version))
    return [Member(n.encode(), content[n], DEFLATE) for n in needed if n not in without]


def describe(xml: bytes, version: int = 2) -> list[Member]:
    """Return the members of an FMU with this description."""
    return [Member(DESCRIPTION.encode(), xml, DEFLATE), *members(version, [DESCRIPTION])]


def replaced(version: int, *pairs: tuple[str, str]) -> bytes:
    """Return a sound description with each pair's first text, which it has, as the second."""
    text = reference.members(version)[DESCRIPTION].decode()
    for old, new in pairs:
        if old not in text:
            raise ValueError(f"{old!r} is not in the description")
        text = text.replace(old, new, 1)
    return text.encode()


def sound(path: Path) -> None:
    """Write the reference FMU."""
    reference.pack(path, reference.members(2))


def fmu(
    group: int, name: str, about: str, says: str, data: Callable[[], bytes], more: str = ""
) -> Case:
    """Return a case of bytes that are run as an FMU."""
    return Case(group, name, about, says, f"simulate a.fmu {more}", {"a.fmu": lambda _: data()})


def spoils(group: int, prefix: str, old: str, new: str = "{}") -> Callable[..., Case]:
    """Return what makes cases in whose descriptions other texts stand in the place of one."""

    def case(name: str, about: str, says: str, written: str) -> Case:
        return spoilt(group, f"{prefix}-{name}", about, says, (old, new.format(written)))

    return case


def spoilt(
    group: int, name: str, about: str, says: str, *pairs: tuple[str, str], version: int = 2
) -> Case:
    """Return a case of a sound FMU whose description has other texts."""
    return fmu(
        group, name, about, says, lambda: zipped(describe(replaced(version, *pairs), version))
    )
