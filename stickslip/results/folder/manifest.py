"""What belongs to a folder of results: which command wrote which files, and their hashes."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stickslip.errors import ResultsError
from stickslip.fmi.files import MOST_TEXT, digest, parse_json, read_limited, require_regular_file

MANIFEST = "manifest.json"

Share = tuple[Mapping[str, Any], frozenset[str]]
"""A command and the names of its files."""

_PART = r"(?!\.{1,2}(?:/|$))[^/\\:]+"
_NAME = re.compile(rf"{_PART}(?:/{_PART})*")
_HASH = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Manifest:
    """The content of manifest.json.

    Parameters
    ----------
    command : the one that wrote last: its name and options
    sha256 : of each file, by its name in the folder, with ``/`` between the parts
    earlier : other commands whose files are still there: name -> (command, names of its files)
    """

    command: Mapping[str, Any]
    sha256: Mapping[str, str]
    earlier: Mapping[str, Share] = field(default_factory=dict)

    @property
    def own(self) -> frozenset[str]:
        """Names of the files that the last command wrote."""
        return frozenset(self.sha256).difference(*(names for _, names in self.earlier.values()))

    def followed_by(self, later: Manifest) -> Manifest:
        """Return the manifest after another command has written its set into the folder.

        The set that the same command wrote before goes; files of other commands stay.
        """
        others = {**self.earlier, _name(self.command): (self.command, self.own)}
        others.pop(_name(later.command), None)
        left = {name: (by, files - later.sha256.keys()) for name, (by, files) in others.items()}
        earlier = {name: (by, files) for name, (by, files) in left.items() if files}
        kept = frozenset[str]().union(*(files for _, files in earlier.values()))
        hashes = {name: self.sha256[name] for name in kept} | dict(later.sha256)
        return Manifest(later.command, hashes, earlier)

    def without(self, names: frozenset[str]) -> Manifest:
        """Return the manifest of a folder in which some files are not."""
        hashes = {name: known for name, known in self.sha256.items() if name not in names}
        earlier = {name: (by, files - names) for name, (by, files) in self.earlier.items()}
        return Manifest(self.command, hashes, earlier)

    def text(self) -> str:
        """Return the content of manifest.json."""
        content: dict[str, Any] = {
            "command": dict(self.command),
            "sha256": dict(sorted(self.sha256.items())),
        }
        if self.earlier:
            content["earlier"] = [
                {"command": dict(by), "files": sorted(files)} for by, files in self.earlier.values()
            ]
        return json.dumps(content, indent=2) + "\n"

    @classmethod
    def read(cls, folder: Path) -> Manifest:
        """Read it from a folder.

        Raises
        ------
        ResultsError
            When there is none, or none that can be trusted to name files of the folder.
        """
        path = folder / MANIFEST
        try:
            require_regular_file(path)
            return cls._of(parse_json(read_limited(path, MOST_TEXT)))
        except FileNotFoundError:
            raise ResultsError(
                f"{path}: there is none; it is written by the commands that write results"
            ) from None
        except OSError as error:
            raise ResultsError(f"{path}: cannot be read ({error.strerror})") from None
        except (ValueError, ResultsError) as error:
            raise ResultsError(f"{path}: not a manifest of results ({error})") from None

    @classmethod
    def _of(cls, content: object) -> Manifest:
        if not isinstance(content, dict):
            raise ResultsError("it does not contain an object")
        command, hashes = content.get("command", {}), content.get("sha256")
        if not isinstance(command, dict):
            raise ResultsError("'command' is not an object")
        if not isinstance(hashes, dict):
            raise ResultsError("'sha256' is missing or not an object")
        for name, known in hashes.items():
            if not (_NAME.fullmatch(name) and name.isprintable()) or name == MANIFEST:
                raise ResultsError(
                    f"it names {name!r}, which is not the name of a file in the folder"
                )
            if not isinstance(known, str) or not _HASH.fullmatch(known):
                raise ResultsError(f"the value of {name!r} is not a SHA-256 (64 hex digits)")
        return cls(command, hashes, _earlier(content.get("earlier", []), hashes))


def hash_of(path: Path) -> str:
    """Return the SHA-256 of a plain file.

    Raises
    ------
    OSError
        When it is not there, is a link or no file, or cannot be read.
    """
    require_regular_file(path)
    return digest(path)


def _earlier(content: object, hashes: Mapping[str, str]) -> dict[str, Share]:
    message = "'earlier' is not a list of commands, each with files that 'sha256' contains"
    if not isinstance(content, list):
        raise ResultsError(message)
    earlier: dict[str, Share] = {}
    for entry in content:
        command, names = (
            (entry.get("command"), entry.get("files")) if isinstance(entry, dict) else (None, None)
        )
        if not isinstance(command, dict) or not isinstance(names, list):
            raise ResultsError(message)
        if not all(isinstance(name, str) and name in hashes for name in names):
            raise ResultsError(message)
        earlier[_name(command)] = (command, frozenset(names))
    return earlier


def _name(command: Mapping[str, Any]) -> str:
    return str(command.get("name", "reproduce"))  # which wrote manifests before they had names
