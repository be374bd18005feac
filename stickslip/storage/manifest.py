"""What belongs to a folder of results: which command wrote which files, and their hashes."""

import errno
import json
import os
import re
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stickslip.errors import ResultsError, UsageError
from stickslip.fmi.files import MOST_TEXT, digest, parse_json, read_limited, require_regular_file

MANIFEST = "manifest.json"

Command = Mapping[str, Any]  # Name and options of a command

_HASH = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Manifest:
    """The content of manifest.json."""

    command: Command  # the one that wrote last
    # of each file, by its name in the folder, with ``/`` between the parts
    sha256: Mapping[str, str]
    # by the names of files that other commands wrote: the command
    earlier: Mapping[str, Command] = field(default_factory=dict)

    def followed_by(self, later: "Manifest", removed: Collection[str]) -> "Manifest":
        """Return the manifest after another command has written its set into the folder.

        The set that the same command wrote before goes; files of other commands stay, but for
        those that are removed.
        """
        left = sorted(self.sha256.keys() - later.sha256.keys() - set(removed))
        by = {name: self.earlier.get(name, self.command) for name in left}
        kept = {name: c for name, c in by.items() if _name(c) != _name(later.command)}
        hashes = {name: self.sha256[name] for name in kept} | dict(later.sha256)
        return Manifest(later.command, hashes, kept)

    def text(self) -> str:
        """Return the content of manifest.json."""
        content: dict[str, Any] = {
            "command": dict(self.command),
            "sha256": dict(sorted(self.sha256.items())),
        }
        groups: dict[str, dict[str, Any]] = {}
        for name, command in sorted(self.earlier.items()):
            group = groups.setdefault(_name(command), {"command": dict(command), "files": []})
            group["files"].append(name)
        if groups:
            content["earlier"] = list(groups.values())
        return json.dumps(content, indent=2) + "\n"

    @classmethod
    def read(cls, folder: Path) -> "Manifest":
        """Read it from a folder; raise ResultsError where none is there that can be trusted."""
        path = folder / MANIFEST
        try:
            require_regular_file(path)
            content = parse_json(read_limited(path, MOST_TEXT))
            hashes, others = content["sha256"], content.get("earlier", [])
            earlier = {name: other["command"] for other in others for name in other["files"]}
            manifest = cls(content.get("command", {}), hashes, earlier)
            sound = (
                all(isinstance(c, dict) for c in (manifest.command, *earlier.values()))
                and all(_is_name(n) and _HASH.fullmatch(known) for n, known in hashes.items())
                and earlier.keys() <= hashes.keys()
            )
        except FileNotFoundError:
            raise ResultsError(
                f"{path}: there is none; it is written by the commands that write results"
            ) from None
        except OSError as error:
            raise ResultsError(f"{path}: cannot be read ({error.strerror})") from None
        except (ValueError, TypeError, AttributeError, KeyError):
            sound = False
        if not sound:
            raise ResultsError(
                f"{path}: not a manifest of results; expected 'command' and 'sha256', the hashes "
                "by names of files in the folder"
            )
        return manifest


def _is_name(name: str) -> bool:
    """Return whether a name is that of a file below the folder, on any system."""
    inside = all(part not in ("", ".", "..") for part in name.split("/"))
    return inside and name.isprintable() and not set(name) & set("\\:") and name != MANIFEST


def _name(command: Command) -> str:
    return str(command.get("name", "reproduce"))  # manifests were written before they had names


def hash_of(path: Path) -> str:
    """Return the SHA-256 of a plain file; raise OSError when it is none, or cannot be read."""
    require_regular_file(path)
    return digest(path)


def refuse_foreign(folder: Path, names: Iterable[str]) -> None:
    """Refuse to replace or delete files that the manifest does not list as they are.

    The files, with ``/`` between the parts of their names, may be absent. Raises UsageError when
    there is one of another origin, or one that was changed; it names the first, or OSError when a
    link, a folder or a device is in the way; it names it.
    """
    listed: Mapping[str, str] = {}
    if os.path.lexists(folder / MANIFEST):
        try:
            listed = Manifest.read(folder).sha256
        except ResultsError as error:
            raise UsageError(
                f"{error}; it is not overwritten: move it away, or choose another <out>"
            ) from None
    for name in sorted(names):
        refuse_places(folder, name)
        with suppress(FileNotFoundError, NotADirectoryError):
            if hash_of(folder / name) != listed.get(name):
                why = (
                    "was changed after stickslip had written it"
                    if name in listed
                    else f"exists, and no {MANIFEST} lists it as a result of stickslip"
                )
                raise UsageError(
                    f"{folder / name}: {why}; it is not overwritten: move it away, or choose "
                    "another <out>"
                )


def refuse_places(folder: Path, name: str) -> None:
    """Raise OSError, which names it, where a link, folder or file is in the place of a file."""
    for place in [folder / parent for parent in Path(name).parents[-2::-1]]:
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            raise OSError(errno.ENOTDIR, "is in the way, expected a folder", str(place))
    require_regular_file(folder / name)


def unchanged(folder: Path, manifest: Manifest, names: Iterable[str]) -> list[Path]:
    """Return those of the files that are as the manifest lists them."""
    found = []
    for name in names:
        with suppress(OSError):
            refuse_places(folder, name)
            if hash_of(folder / name) == manifest.sha256[name]:
                found.append(folder / name)
    return found
