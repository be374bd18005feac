"""Sources in, a shared library out, once."""

import ctypes
import importlib.util
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from stickslip.fmi import toolchain
from stickslip.fmi.toolchain import compiler
from tests.corpus.fmu import EXPORT
from tests.kept import further

ANSWER = {
    "answer.h": f"{EXPORT}EXPORT int answer(void);\n#ifndef ANSWER\n#define ANSWER 42\n#endif\n",
    "answer.c": '#include "answer.h"\nint answer(void) { return ANSWER; }\n',
}


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give this test a cache of its own; the compiler keeps its own files where they are."""
    kept = toolchain.cache_directory() / "zig"
    kept.mkdir(parents=True, exist_ok=True)
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "zig").symlink_to(kept)
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Count what is really compiled."""
    done: list[str] = []
    original = compiler._compile

    def counted(command, files, output):
        done.append(output)
        return original(command, files, output)

    monkeypatch.setattr(compiler, "_compile", counted)
    return done


@pytest.mark.usefixtures("fresh")
def test_what_loads_other_libraries_does_not_count_as_compiled_here():
    own = toolchain.shared_library("own", ANSWER)
    loading = toolchain.shared_library("loading", ANSWER, flags=["-DANSWER=7"], loads=True)
    assert [toolchain.compiled_here(path) for path in (own, loading)] == [True, False]


@pytest.mark.usefixtures("fresh")
def test_whatever_goes_in_makes_another_file(compilations):
    header = ANSWER | {"answer.h": ANSWER["answer.h"].replace("42", "43")}
    made = [
        toolchain.shared_library("answer", ANSWER),
        toolchain.shared_library("answer", ANSWER, flags=["-DANSWER=7"]),
        toolchain.shared_library("answer", header),
        toolchain.shared_library("reply", ANSWER),
    ]
    assert len(set(made)) == len(compilations) == 4
    assert [ctypes.CDLL(str(path)).answer() for path in made] == [42, 7, 43, 42]


def _flipped(content: bytes) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.usefixtures("fresh")
def test_who_asks_while_it_is_compiled_waits_for_it(compilations):
    with ThreadPoolExecutor(3) as pool:
        found = set(pool.map(lambda _: toolchain.shared_library("answer", ANSWER), range(3)))
    assert len(found) == len(compilations) == 1


@pytest.mark.usefixtures("fresh")
@pytest.mark.parametrize(
    "damage",
    [
        lambda _: b"",
        lambda content: bytes(len(content)),
        lambda content: content[: len(content) // 2],
        lambda content: content + b"x",
        _flipped,
    ],
    ids=["empty", "zeros", "cut", "longer", "one bit"],
)
@pytest.mark.parametrize("end", ["", *further(".sha256")])
def test_a_damaged_library_or_hash_of_it_is_built_again(compilations, damage, end):
    """The cache is written to by nobody else, but disks fill up and power fails."""
    path = toolchain.shared_library("answer", ANSWER)
    damaged, whole = path.with_name(path.name + end), path.read_bytes()
    content = damaged.read_bytes()
    damaged.unlink()
    damaged.write_bytes(damage(content))
    again = toolchain.shared_library("answer", ANSWER)
    assert again == path
    assert again.read_bytes() == whole
    assert len(compilations) == 2
    toolchain.shared_library("answer", ANSWER)
    assert len(compilations) == 2


def test_a_failed_compilation_says_where_and_leaves_nothing(fresh):
    with pytest.raises(toolchain.CompilationFailed) as failure:
        toolchain.shared_library("answer", {"wrong.c": "int answer(void) { return nothing; }\n"})
    message = str(failure.value)
    assert message.startswith("cannot compile answer")
    assert "wrong.c:1:" in message
    assert "nothing" in message
    assert not list(fresh.glob("libraries/*/*"))


@pytest.mark.usefixtures("fresh")
def test_warnings_are_errors():
    loss = ANSWER | {"loss.c": "int loss(double x);\nint loss(double x) { return x; }\n"}
    with pytest.raises(toolchain.CompilationFailed, match="conversion"):
        toolchain.shared_library("answer", loss)


def test_a_missing_compiler_is_named_with_the_cure(monkeypatch):
    compiler.compiler_version.cache_clear()
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    with pytest.raises(toolchain.CompilerMissing, match=r"pip install '.*\[compile\]'"):
        toolchain.shared_library("answer", ANSWER)
    monkeypatch.undo()
    compiler.compiler_version.cache_clear()


def test_a_cache_that_cannot_be_written_is_one_line_with_our_setting(tmp_path, monkeypatch):
    """Not hundreds of the compiler's, which names a setting of its own."""
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    for word in ("NoSpaceLeft", "AccessDenied"):
        printed = f"warning(zcu): unable to write cached ZIR code: {word}\n" * 700
        monkeypatch.setattr("stickslip.fmi.toolchain.compiler._run", lambda *_, p=printed: (1, p))
        with pytest.raises(toolchain.CacheUnusable) as caught:
            toolchain.shared_library("answer", ANSWER)
        assert str(caught.value).count("\n") == 0
        assert "set STICKSLIP_CACHE to" in str(caught.value)
    (tmp_path / "file").touch()
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "file"))
    with pytest.raises(toolchain.CacheUnusable, match=r"file.*: .*; set STICKSLIP_CACHE to"):
        toolchain.shared_library("answer", ANSWER)


@pytest.mark.usefixtures("fresh")
def test_what_texts_lead_to_is_made_once_for_each_of_them():
    made = []

    def make() -> bytes:
        made.append(b"made %d" % len(made))
        return made[-1]

    found = [toolchain.kept(*one, make) for one in 2 * [("a", "x"), ("a", "y"), ("b", "x")]]
    assert found == 2 * [b"made 0", b"made 1", b"made 2"]
