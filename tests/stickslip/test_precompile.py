"""What a wheel carries compiled serves in place of a compiler."""

from contextlib import contextmanager

import pytest

from stickslip import models
from stickslip.cosim import kernel
from stickslip.cosim.fmu.library import fmi1_wrapper
from stickslip.fmi import toolchain
from stickslip.fmi.binary import read_library
from stickslip.fmi.toolchain import PLATFORMS, compiler, host_platform
from stickslip.precompile import precompile
from stickslip.servo.measurement import section_library


@pytest.fixture(scope="module")
def without_compiler(tmp_path_factory):
    """Have an archive with the stage and the kernel for this machine; else nothing, no cache."""
    folder = tmp_path_factory.mktemp("wheel")
    archive = precompile(folder / "compiled.zip", [host_platform()], ["stage"])

    def missing():
        raise toolchain.CompilerMissing("none")

    @contextmanager
    def without():
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("STICKSLIP_CACHE", str(folder / "cache"))
            patch.setattr("stickslip.fmi.toolchain.compiler.ARCHIVE", archive)
            patch.setattr(compiler, "compiler_version", missing)
            yield patch

    return without


@pytest.mark.parametrize(("law", "fmi"), [("lugre", 2), ("gms", 3)])
def test_a_model_is_the_one_that_is_compiled(law, fmi, tmp_path, without_compiler):
    wanted = {"law": law, "fmi": fmi, "start": {"m": 5.5}, "called": "mine"}
    compiled = models.build_fmu("stage", tmp_path / "compiled", **wanted)
    with without_compiler():
        shipped = models.build_fmu("stage", tmp_path / "shipped", **wanted)
    assert shipped.read_bytes() == compiled.read_bytes()


def test_what_runs_fmus_is_there(without_compiler):
    compiled = [kernel.built(), kernel.built(marked=True), fmi1_wrapper(), section_library()]
    with without_compiler():
        build = kernel.built.__wrapped__  # which is cached
        shipped = [build(), build(marked=True), fmi1_wrapper(), section_library()]
    assert not set(shipped) & set(compiled)
    assert [path.read_bytes() for path in shipped] == [path.read_bytes() for path in compiled]


def test_what_is_not_there_needs_the_compiler(tmp_path, without_compiler):
    with without_compiler() as patch:
        with pytest.raises(toolchain.CompilerMissing):
            models.build_fmu("drive", tmp_path)
        patch.setenv("STICKSLIP_CFLAGS", "-O1")  # another library
        with pytest.raises(toolchain.CompilerMissing):
            models.build_fmu("stage", tmp_path)


NATIVE = ("x86_64-linux", "aarch64-darwin")  # one of each kind


@pytest.mark.parametrize(
    "platform",
    [  # Windows' C runtime takes a minute to compile
        pytest.param(p, marks=[pytest.mark.thorough] * (p.tuple not in NATIVE), id=p.tuple)
        for p in PLATFORMS.values()
    ],
)
def test_the_kernel_is_compiled_for_each_platform(platform):
    assert "advance" in read_library(kernel.built(platform=platform).read_bytes()).exports
    assert read_library(fmi1_wrapper(platform).read_bytes()).exports
