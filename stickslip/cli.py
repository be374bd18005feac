"""The command ``stickslip``."""

import argparse
import os
import re
import signal
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from difflib import get_close_matches
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from stickslip.commandline import is_rare
from stickslip.errors import settings_as_options
from stickslip.fmi import process
from stickslip.fmi.additions import own_folder
from stickslip.fmi.errors import Fault
from stickslip.fmi.messages import harmless, suggestion
from stickslip.output import answered, messages

_NUMBER = re.compile(r"-\.?\d")
_SUFFIX = re.compile(r"\.\w+")


class _HelpFormatter(argparse.HelpFormatter):
    """Keeps the lines of examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if "\n" in text else super()._fill_text(text, width, indent)


class Parser(argparse.ArgumentParser):
    """A parser that finds files wherever they stand; its errors are one line.

    ``argparse`` gives an option of several values all words up to the next option, also the file
    that the command is for. Here an option takes only words that its choices, its type or the form
    of its metavar (``NAME=VALUE``) allow; where a file is then missing, it is the word among the
    values of options that exists or has the suffix of the missing argument's metavar.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        settings.setdefault("formatter_class", _HelpFormatter)
        super().__init__(*args, **settings)
        self.add_argument("--help-all", action=_HelpAll, nargs=0, help=argparse.SUPPRESS)
        self._negative_number_matcher = _NUMBER  # also -1e-3, before Python 3.14
        common = self.add_argument_group("common options")
        for names, text in {
            ("--json",): "print the result as JSON, and nothing else on standard output",
            ("-q", "--quiet"): "print errors only",
            ("-v", "--verbose"): "also print stages and notes, and all tables of learn",
            ("--debug",): "show the traceback of an error",
        }.items():
            common.add_argument(*names, action="store_true", default=argparse.SUPPRESS, help=text)

    def format_help(self, *, rare: bool = False) -> str:
        """Return the help, without the options of rare groups unless they are asked for."""
        groups = (group for group in self._action_groups if is_rare(group))
        hidden = [] if rare else [one for group in groups for one in group._group_actions]  # noqa: SLF001 - no public name
        texts = [action.help for action in hidden]
        for action in hidden:
            action.help = argparse.SUPPRESS
        shown = super().format_help()
        for action, text in zip(hidden, texts, strict=True):
            action.help = text
        more = f"\n{len(hidden)} more options: {self.prog} --help-all\n" if hidden else ""
        return shown + more

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
        """Return the words, positional ones first; what follows a command has its own parser."""
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
            listed = (a.option_strings for a in self._actions if a.help != argparse.SUPPRESS)
            shown = [option for options in listed for option in options if option.startswith("--")]
            self.error(f"there is no option {name!r}{suggestion(name, shown)}")
        if len({known[option].dest for option in begun}) > 1:
            self.error(f"{name} is short for several options: {', '.join(begun)}")
        return known[begun[0]]

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


_HELP = re.compile(r'"""``stickslip (\w+)``: ([^"]+?)\.?(?:""")?$')

_EXAMPLE = re.compile(r"^ *(stickslip .+)$", re.MULTILINE)  # in the text of a command's module
_PLACES = ("commands/*.py", "studies/*/command.py", "papers/*/commands/*.py")


class Command(NamedTuple):
    """A command: the module that declares and runs it, imported when it is called, and its help."""

    module: str
    does: str


def _commands() -> dict[str, Command]:
    """Return the commands by name, from the first line of their modules."""
    found, root = {}, Path(__file__).parent
    own = (own_folder() / "commands").glob("*.py")
    for path in (*(path for place in _PLACES for path in root.glob(place)), *own):
        with path.open(encoding="utf-8") as file:
            line = _HELP.match(file.readline().rstrip())
        if line:
            inside = path.relative_to(root if path.is_relative_to(root) else own_folder())
            module = ".".join(("stickslip", *inside.with_suffix("").parts))
            found[line[1]] = Command(module, line[2])
    return dict(sorted(found.items()))


COMMANDS = _commands()
EXPECTED = (Fault, OSError, MemoryError)  # that a user can cause; others are defects
_MOST_FILES = 10_000  # of a folder, among which a suggestion is looked for
_LONGEST = 2000  # characters of a message, which may contain text from a file


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status: 0, 1 for an error, 2 for usage, 130 for Ctrl-C.

    A SIGTERM or SIGHUP ends a command as Ctrl-C does, with 143 and 129.
    """
    if "_ARGCOMPLETE" in os.environ:  # a shell asks for completions
        _complete(os.environ["COMP_LINE"].split()[1:])
    process.open_standard_streams()  # those that cron or a service has closed
    given = list(sys.argv[1:] if arguments is None else arguments)
    plain = argparse.Namespace(json=False, quiet=False, verbose=False, debug=False)
    parser = _parser(given)
    if not given:
        parser.print_help()
        return 0
    options = parser.parse_args(given, plain)
    with process.interruptible(), messages(options), settings_as_options():
        try:
            return _status(options)
        except KeyboardInterrupt as interruption:
            with suppress(OSError):  # the terminal may be gone
                print(f"stickslip: {str(interruption) or 'interrupted'}", file=sys.stderr)
            try:
                sys.stdout.flush()
            except OSError:
                _drop_output()
            return 128 + (process.interrupted_by() or signal.SIGINT)


def _status(options: argparse.Namespace) -> int:
    try:
        status = answered(options, options.run)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of the output has ended
        _drop_output()
        return 1
    except Exception as error:
        process.check_interruption()  # which may be the cause
        if options.debug or not isinstance(error, EXPECTED):
            raise
        print(f"stickslip: {_line(error)}", file=sys.stderr)
        return 1
    return status


def _drop_output() -> None:
    """Discard later output, so that no error follows at the exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _HelpAll(argparse.Action):
    """Prints the help with rare options."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        assert isinstance(parser, Parser)  # noqa: S101 - it adds this action
        print(parser.format_help(rare=True), end="")
        parser.exit()


class _Version(argparse.Action):
    """Prints the installed version, which takes time to find."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version  # late, for commands that start quickly

        print(f"stickslip {version('stickslip')}")
        parser.exit()


def _parser(arguments: Sequence[str]) -> argparse.ArgumentParser:
    parser = Parser(
        prog="stickslip", description="Learn a friction compensator for a servo drive, in FMUs."
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show it and leave")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    called = next((word for word in arguments if not word.startswith("-")), None)
    for name, (module, does) in COMMANDS.items():
        command = subparsers.add_parser(name, help=does)
        if name == called:
            try:
                found = import_module(module)
                found.declare(command)
            except Exception as fault:
                if "--debug" in arguments:
                    raise
                why = _line(fault)
                command.exit(1, f"stickslip: {module}: {type(fault).__name__}: {why}; mend it\n")
            if examples := _EXAMPLE.findall(found.__doc__ or ""):
                command.epilog = "\n  ".join(["examples:", *examples])
    return parser


def _complete(words: Sequence[str]) -> None:
    """Answer the shell and exit: commands, options, choices, and files where one is expected."""
    from argcomplete import autocomplete
    from argcomplete.completers import BaseCompleter, FilesCompleter

    class Files(BaseCompleter):
        def __call__(self, *, prefix: str, action: argparse.Action, **_: object) -> Iterable[str]:
            suffixes = suffixes_of(action)
            return FilesCompleter(suffixes)(prefix) if suffixes or action.type is Path else ()

    autocomplete(_parser(words), "long", exclude=["FILE.ssp"], default_completer=Files())


def _near(path: Path) -> str:
    """Return the end of a message that suggests a file with nearly the name of a missing one."""
    try:
        with os.scandir(path.parent) as entries:
            names = [entry.name for entry in islice(entries, _MOST_FILES)]
    except OSError:
        return ""
    near = get_close_matches(path.name, names, n=1, cutoff=0.75)
    return f"; did you mean '{path.with_name(near[0])}'?" if near else ""


def _line(error: BaseException) -> str:
    """Return the message of an error in one line; only that of a compiler has more lines."""
    from stickslip.fmi.toolchain import ToolchainError  # late, for those who start quickly

    message = str(error)
    if isinstance(error, ToolchainError):
        return message
    if isinstance(error, MemoryError):
        message = "not enough memory; reduce the size of the input"
    if isinstance(error, OSError) and error.filename:
        message = f"{error.filename}: {error.strerror}"
        if isinstance(error, FileNotFoundError):
            message += _near(Path(os.fsdecode(error.filename)))
    return harmless((" ".join(message.split()) or type(error).__name__)[:_LONGEST])
