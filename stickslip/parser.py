"""The parser of command lines: words in any order, and suggestions for what is mistyped."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from stickslip.fmi.messages import suggestion

_NUMBER = re.compile(r"-\.?\d")
_SUFFIX = re.compile(r"\.\w+")


class Parser(argparse.ArgumentParser):
    """A parser that finds files wherever they stand; its errors are one line.

    ``argparse`` gives an option of several values all words up to the next option, also the file
    that the command is for. Here an option takes only words that its choices, its type or the form
    of its metavar (``NAME=VALUE``) allow; where a file is then missing, it is the word among the
    values of options that exists or has the suffix of the missing argument's metavar.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._negative_number_matcher = _NUMBER  # also -1e-3, before Python 3.14
        common = self.add_argument_group("common options")
        for names, text in {
            ("--json",): "print the result as JSON, and nothing else on standard output",
            ("-q", "--quiet"): "print errors only",
            ("-v", "--verbose"): "also print each stage and notes on standard error",
            ("--debug",): "show the traceback of an error",
        }.items():
            common.add_argument(*names, action="store_true", default=argparse.SUPPRESS, help=text)

    def error(self, message: str) -> NoReturn:
        """End with a line that names the help."""
        end = " see" if message.endswith("?") else "; see"
        self.exit(2, f"stickslip: {message}{end} '{self.prog} --help'\n")

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse words in any order."""
        return super().parse_known_args(self._arranged(list(args or ())), namespace)

    def _arranged(self, words: list[str]) -> list[str]:
        """Return the words with the positional ones first.

        Those of a parser with commands keep their order: what follows a command is parsed by the
        command's own parser.
        """
        commands = next((a for a in self._actions if a.nargs == argparse.PARSER), None)
        if commands is not None:
            return _command_first(words, commands)
        files: list[str] = []
        options: list[tuple[argparse.Action, list[str]]] = []
        refused: dict[str, argparse.Action] = {}
        rest = list(reversed(words))
        while rest:
            word = rest.pop()
            if word == "--":
                files += reversed(rest)
                break
            if not _is_option(word):
                files.append(word)
                continue
            taken, action = [word], self._option(word)
            least, most = _numbers(action, word)
            while (
                rest
                and len(taken) <= most
                and not _is_option(rest[-1])
                and (len(taken) <= least or _accepts(action, rest[-1]))
            ):
                taken.append(rest.pop())
            if len(taken) <= most and rest and not _is_option(rest[-1]):
                refused[rest[-1]] = action
            options.append((action, taken))
        places = self._get_positional_actions()
        if len(files) > len(places) and all(a.nargs in (None, "?") for a in places):
            wrong = next((word for word in files if word in refused), files[len(places)])
            self._refuse(wrong, refused.get(wrong))
        wanted = [action for action in places if action.nargs != "*"]
        for action in wanted[len(files) :]:
            files += _misplaced(action, options)
        flat = [word for _, taken in options for word in taken]
        if any(map(_is_option, files)):
            return [*flat, "--", *files]
        return [*files, *flat]

    def _option(self, word: str) -> argparse.Action:
        """Return the option that a word names in full or begins to name."""
        name = word.partition("=")[0]
        known = self._option_string_actions
        if name in known:
            return known[name]
        begun = [option for option in known if option.startswith(name)]
        if not (name.startswith("--") and begun):
            self._refuse_option(name)
        if len({known[option].dest for option in begun}) > 1:
            self.error(f"{name} is short for several options: {', '.join(begun)}")
        return known[begun[0]]

    def _refuse_option(self, name: str) -> NoReturn:
        """End with the options that look like one that is not known."""
        listed = (a.option_strings for a in self._actions if a.help != argparse.SUPPRESS)
        shown = [option for options in listed for option in options if option.startswith("--")]
        self.error(f"there is no option {name!r}{suggestion(name, shown)}")

    def _refuse(self, word: str, action: argparse.Action | None) -> NoReturn:
        """End with what is wrong with a word that follows an option, or no option."""
        if action is None:
            self.error(f"there is no place for {word!r}; values follow the name of an option")
        try:
            self._check_value(action, self._get_value(action, word))
        except argparse.ArgumentError as fault:
            self.error(str(fault))
        self.error(f"argument {action.option_strings[0]}: expected {action.metavar}, got {word!r}")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Raise where a value is not one of the choices, and suggest one."""
        if action.choices is not None and value not in action.choices:
            near = suggestion(str(value), [str(one) for one in action.choices])
            raise argparse.ArgumentError(action, f"there is no {str(value)!r}{near}")


def _command_first(words: list[str], commands: argparse.Action) -> list[str]:
    """Return the words with a command, such as a file to export, ahead of the options."""
    if words and _is_option(words[0]):
        named = [word for word in words if word in (commands.choices or ())]
        if len(named) == 1:
            return [*named, *(word for word in words if word not in named)]
    return words


def _is_option(word: str) -> bool:
    name = word.partition("=")[0]
    return len(word) > 1 and word[0] == "-" and not _NUMBER.match(word) and " " not in name


def _numbers(action: argparse.Action, word: str) -> tuple[int, float]:
    """Return how many words an option takes, at least and at most."""
    if word.startswith("--") and "=" in word:
        return 0, 0
    if isinstance(action.nargs, int):
        return action.nargs, action.nargs
    several = {"+": (1, float("inf")), "*": (0, float("inf")), "?": (0, 1)}
    return several[action.nargs] if action.nargs else (1, 1)


def _accepts(action: argparse.Action, word: str) -> bool:
    """Tell whether a word can be a value of an option."""
    if action.choices is not None and word not in action.choices:
        return False
    if isinstance(action.metavar, str) and "=" in action.metavar and "=" not in word:
        return False
    if not callable(action.type):
        return True
    try:
        action.type(word)
    except (argparse.ArgumentTypeError, TypeError, ValueError):
        return False
    return True


def suffixes_of(action: argparse.Action) -> list[str]:
    """Return the suffixes of files that a metavar such as ``FILE.csv|FILE.parquet`` names."""
    return _SUFFIX.findall(str(action.metavar))


def _misplaced(
    wanted: argparse.Action, options: list[tuple[argparse.Action, list[str]]]
) -> list[str]:
    """Remove the file that is wanted from the values of an option, and return it, if any."""
    suffixes = suffixes_of(wanted)
    for action, taken in reversed(options):
        least, most = _numbers(action, taken[0])
        if least == most or len(taken) - 1 <= least:
            continue
        for word in taken[:0:-1]:
            if Path(word).suffix in suffixes or Path(word).exists():
                taken.remove(word)
                return [word]
    return []
