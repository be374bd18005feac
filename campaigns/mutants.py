"""Which faults, put into the sources one at a time, the tests find.

    python -m campaigns.mutants --number 40 --out mutants.csv [--rooms cosim stickslip/rigs]

A mutant is one changed place of a copy of the checkout: another comparison, + for -, a number
doubled, ``and`` for ``or``, a returned value negated, a condition dropped, a call removed; in C
another operator. The sample takes the rooms in turn and, in a room, the kinds of change at random.
The tests most likely to fail run until one does: those that import the module or name the function
that was changed, then those of its folder. mutants.csv has a row for each mutant and is rewritten
after each; mutants that it has are not tried again. Tests that also fail without a mutant are
printed at the end.
"""

import argparse
import ast
import csv
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice, zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
FOLDERS = ("fmi", "models", "cosim", "fmucheck", "ga", "stickslip")
FINDER = "__editable___stickslip_0_1_0_finder"
"""Module by which an editable installation finds the packages in the checkout."""
COMPARED = {ast.Lt: ast.LtE, ast.Gt: ast.GtE, ast.Eq: ast.NotEq, ast.Is: ast.IsNot}
COMPARED |= {ast.In: ast.NotIn} | {other: one for one, other in COMPARED.items()}
OF_C = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+"}
TEXTS = ("'", '"', "f'", 'f"', "[")
"""How operands of + begin that have no -."""
FILES = 8
"""Most files of tests that a mutant is tried with."""
HEAD = ("place", "change", "result", "seconds")


@dataclass(frozen=True)
class Mutant:
    """A change of the text old, whose bytes begin at begin; near are the names around it."""

    path: Path
    line: int
    kind: str
    begin: int
    old: str
    text: str
    near: tuple[str, ...]

    @property
    def row(self) -> tuple[str, str]:
        """Place and change, as in the table."""
        place = f"{self.path.relative_to(ROOT)}:{self.line}"
        return place, " ".join(f"{self.kind}: {self.old} -> {self.text}".split())[:160]


def nodes(node: ast.AST, near: tuple[str, ...] = ()) -> Iterator[tuple[ast.AST, tuple[str, ...]]]:
    """Yield what can be changed, with the names of the functions and classes around it."""
    yield node, near
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list") or isinstance(node, ast.JoinedStr):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                yield from nodes(child, (*near, child.name))
            elif isinstance(child, ast.AST):
                yield from nodes(child, near)


def changes(node: ast.AST) -> Iterator[tuple[str, ast.AST, str]]:
    """Yield the kind of a change, the node that it replaces, and its text."""
    match node:
        case ast.Compare(ops=[op]) if type(op) in COMPARED:
            other = ast.Compare(node.left, [COMPARED[type(op)]()], node.comparators)
            yield "comparison", node, ast.unparse(other)
        case ast.BinOp(left, ast.Add() | ast.Sub() as op, right):
            if not any(ast.unparse(one).startswith(TEXTS) for one in (left, right)):
                other = ast.BinOp(left, ast.Sub() if isinstance(op, ast.Add) else ast.Add(), right)
                yield "sign", node, ast.unparse(other)
        case ast.Constant(value) if type(value) in (int, float):
            yield "number", node, repr(2 * value or 1)
        case ast.BoolOp(op, values):
            other = ast.BoolOp(ast.Or() if isinstance(op, ast.And) else ast.And(), values)
            yield "and/or", node, f"({ast.unparse(other)})"
        case ast.Return(ast.Compare() | ast.BoolOp() | ast.UnaryOp(ast.Not()) as value):
            yield "result", value, f"not ({ast.unparse(value)})"
        case ast.Return(ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()) as value):
            yield "result", value, f"-({ast.unparse(value)})"
        case ast.If(test) | ast.IfExp(test) if ast.unparse(test) != "TYPE_CHECKING":
            yield "condition", test, "True"
        case ast.comprehension(ifs=[test, *_]):
            yield "condition", test, "True"
        case ast.Expr(ast.Call()):
            yield "call", node, "pass"


def mutants(path: Path) -> Iterator[Mutant]:
    """Yield all mutants of a file."""
    source = path.read_bytes()
    starts = [0, *(one.end() for one in re.finditer(rb"\n", source))]
    if path.suffix == ".py":
        for node, near in nodes(ast.parse(source)):
            for kind, part, text in changes(node):
                begin = starts[part.lineno - 1] + part.col_offset
                end = starts[part.end_lineno - 1] + part.end_col_offset
                old = source[begin:end].decode()
                yield Mutant(path, part.lineno, kind, begin, old, text, near)
        return
    for line, code in enumerate(source.splitlines(), 1):
        for one in re.finditer(rb"(?<= )([<>]=?|[=!]=|[+-])(?= )", code.partition(b"/*")[0]):
            begin, old = starts[line - 1] + one.start(), one[0].decode()
            if not code.lstrip().startswith((b"*", b"#")):
                yield Mutant(path, line, "C", begin, old, OF_C[old], (path.parent.name,))


def room_of(path: Path) -> str:
    """Return the folder that a file counts to."""
    parts = path.relative_to(ROOT).parts[:-1]
    depth = 3 if parts[1:2] in (("studies",), ("papers",)) else 2
    return "/".join(parts[: depth if parts[0] == "stickslip" else 1])


def draws(files: Sequence[Path], seed: str) -> Iterator[Mutant]:
    """Yield the mutants of a room in a random order, all kinds of change as often."""
    rng, kinds = random.Random(seed), defaultdict(list)  # noqa: S311 - a sample
    for one in chain.from_iterable(map(mutants, files)):
        kinds[one.kind].append(one)
    while kinds:
        kind = rng.choice(sorted(kinds))
        yield kinds[kind].pop(rng.randrange(len(kinds[kind])))
        if not kinds[kind]:
            del kinds[kind]


def tests_of(mutant: Mutant, texts: dict[Path, str]) -> list[str]:
    """Return the files of tests that probably fail, the likeliest first."""
    parts = mutant.path.relative_to(ROOT).with_suffix("").parts
    package = ".".join(parts[:-1] if parts[0] == "stickslip" else ("stickslip", *parts[:-1]))
    public = re.findall(r"^(?:def|class) ([A-Za-z]\w+)", mutant.path.read_text(), re.MULTILINE)
    signs = {
        rf"{package}\.{parts[-1]}\b|from {package} import [^\n]*\b{parts[-1]}\b": 8,
        rf"\b({'|'.join(mutant.near) or '-'})\b": 6,
        rf"\b({'|'.join({*public} - {'run', 'declare', 'main'}) or '-'})\b": 2,
        rf'"({"|".join(parts[-2:])})"': 2,
    }
    mirrored = "/".join(("/tests", *parts[:-1]))

    def score(path: Path) -> tuple[float, int]:
        near = os.path.commonpath((mirrored, f"/{path.relative_to(ROOT)}")).count("/")
        found = sum(points for sign, points in signs.items() if re.search(sign, texts[path]))
        slow = 2 * ("pytestmark = pytest.mark.slow" in texts[path])
        return found + 2 * near + 3 * (path.stem == f"test_{parts[-1]}") - slow, -len(texts[path])

    best = sorted(texts, key=score, reverse=True)[:FILES]
    return [str(path.relative_to(ROOT)) for path in best]


def checkout(folder: Path) -> dict[str, str]:
    """Copy the checkout; return the environment in which Python finds the copy."""
    listed = subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT, text=True)  # noqa: S607 - git of the user
    for name in filter(None, listed.split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    finder = Path(__import__(FINDER).__file__).read_text(encoding="utf-8")
    (folder / ".mapped").mkdir()
    (folder / f".mapped/{FINDER}.py").write_text(finder.replace(str(ROOT), str(folder)))
    return {**os.environ, "PYTHONPATH": str(folder / ".mapped")}


def failures(words: Sequence[str], copy: Path, env: dict[str, str], limit: float) -> list[str]:
    """Run tests; return those that fail."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words]
    how = {"cwd": copy, "env": env, "stderr": subprocess.DEVNULL, "start_new_session": True}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, **how) as running:
        try:
            shown, _ = running.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(running.pid, signal.SIGKILL)
            return ["TIME LIMIT"]
    found = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", shown, re.MULTILINE)
    return found or (["SURVIVED"] if running.returncode in (0, 5) else ["pytest::itself"])


def main() -> None:
    """Draw mutants, try them, write the table."""
    parser = argparse.ArgumentParser(prog="python -m campaigns.mutants", description=__doc__)
    parser.add_argument("--rooms", nargs="+", metavar="ROOM", help="default: all")
    parser.add_argument("--number", type=int, default=40, metavar="N")
    parser.add_argument("--seed", default="0")
    parser.add_argument("--limit", type=float, default=60.0, metavar="S", help="of one's tests")
    parser.add_argument("--out", type=Path, default=Path("mutants.csv"), metavar="FILE")
    options = parser.parse_args()
    rooms = defaultdict(list)
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.*")):
        if path.suffix in (".py", ".c"):
            rooms[room_of(path)].append(path)
    drawn = [draws(rooms[room], options.seed + room) for room in options.rooms or sorted(rooms)]
    sample = islice(filter(None, chain.from_iterable(zip_longest(*drawn))), options.number)
    read = ((path, path.read_text(encoding="utf-8")) for path in ROOT.glob("tests/**/test_*.py"))
    texts = {path: text for path, text in read if "mark = pytest.mark.thorough" not in text}
    rows = {}
    if options.out.exists():
        with options.out.open(newline="", encoding="utf-8") as file:
            rows = {(row[0], row[1]): row[2:] for row in csv.reader(file) if row[0] != HEAD[0]}
    with TemporaryDirectory() as folder:
        copy = Path(folder)
        env, killers = checkout(copy), set()
        for mutant in sample:
            if mutant.row in rows:
                continue
            path, since = copy / mutant.path.relative_to(ROOT), time.monotonic()
            source, end = path.read_bytes(), mutant.begin + len(mutant.old.encode())
            path.write_bytes(source[: mutant.begin] + mutant.text.encode() + source[end:])
            result = failures(["-x", *tests_of(mutant, texts)], copy, env, options.limit)[0]
            path.write_bytes(source)
            rows[mutant.row] = (result, f"{time.monotonic() - since:.0f}")
            killers |= {result} if ".py::" in result else set()
            print(*mutant.row, result, sep=" | ", flush=True)
            with options.out.open("w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([HEAD, *(key + tuple(row) for key, row in rows.items())])
        if killers:
            print("the same without a mutant:", *failures(sorted(killers), copy, env, 600.0))


if __name__ == "__main__":
    main()
