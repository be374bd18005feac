"""An .ssp file, unpacked, and the variants of the system in it."""

from __future__ import annotations

import os
from pathlib import Path

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.markup import attribute, parse
from stickslip.cosim.ssp.names import STRUCTURE
from stickslip.cosim.ssp.structure import unpacked
from stickslip.cosim.system.system import Origin
from stickslip.fmi.messages import suggestion


class Package(Origin):
    """An .ssp file that is unpacked, and the chosen variant."""

    @classmethod
    def open(cls, path: str | os.PathLike[str], variant: str | None = None) -> Package:
        """Unpack a file and choose a variant by the name it gives itself, or by its file."""
        whole = Path(path).absolute()
        package = cls(whole, unpacked(whole))
        if variant is None:
            return package
        named = package.variants()
        files = {file: file for file in named.values()} | named
        if variant not in files:
            raise SspError(f"{whole}: no variant {variant!r}{suggestion(variant, files)}")
        return cls(whole, package.folder, files[variant])

    def variants(self) -> dict[str, str]:
        """Return name -> file of each variant, the default one first.

        Raises
        ------
        SspError
            When one cannot be read, or two have the same name.
        """
        files = sorted(self.folder.glob("*.ssd"), key=lambda file: (file.name != STRUCTURE, file))
        names: dict[str, str] = {}
        for file in files:
            try:
                name = attribute(parse(file, "ssd"), "name")
            except SspError as fault:
                raise SspError(f"{self.path}: {fault}") from fault
            if name in names:
                raise SspError(
                    f"{self.path}: {names[name]} and {file.name} are both called {name!r};"
                    " choose one by its file"
                )
            names[name] = file.name
        return names


def variants(path: str | os.PathLike[str]) -> list[str]:
    """Return the names of the variants that an .ssp file holds, the default one first.

    Raises
    ------
    SspError
    """
    return list(Package.open(path).variants())
