"""``python -m stickslip.precompile`` makes what a wheel carries.

These are, compiled for all platforms, the kernel, the wrapper of FMI 1.0, a filter, and all models
with all friction laws, as FMI 2.0 and 3.0; start values are written into them later. Besides them,
BokehJS for the figures of reports, if the package ``bokeh`` is installed.
"""

import io
import os
import zipfile
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import product
from pathlib import Path

from stickslip import models
from stickslip.cosim import kernel
from stickslip.cosim.fmu.library import fmi1_wrapper
from stickslip.fmi.files import atomic_write
from stickslip.fmi.process import Threads
from stickslip.fmi.toolchain import PLATFORMS, Platform, compiler_version
from stickslip.fmi.toolchain.compiler import ARCHIVE
from stickslip.presentation.interactive import CARRIED, bokeh
from stickslip.servo.measurement import section_library


def precompile(
    archive: Path = ARCHIVE,  # the one that ``fmi.toolchain`` looks into by default
    platforms: Iterable[Platform] = PLATFORMS.values(),  # what to compile for
    names: Iterable[str] | None = None,  # models; all by default
) -> Path:
    """Write an archive of compiled libraries and return its path; raise ToolchainError."""
    jobs = list(_jobs(list(platforms), models.model_names() if names is None else names))
    content = io.BytesIO()
    with (
        zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as written,
        Threads(os.cpu_count()) as pool,
    ):
        written.comment = compiler_version().encode()
        for library in pool.each(lambda job: job(), jobs):
            recipe = library.parent.name.partition("-")[0]
            written.write(library, f"{recipe}/{library.name}")
    return atomic_write(archive, content.getvalue())


def _jobs(platforms: list[Platform], names: Iterable[str]) -> Iterator[Callable[[], Path]]:
    for platform, marked in product(platforms, (False, True)):
        yield partial(kernel.built, marked=marked, platform=platform)
    for platform in platforms:
        yield partial(fmi1_wrapper, platform)
        yield partial(section_library, platform)
    for name in names:
        laws = models.law_names() if models.load_model(name).law else [None]
        for law, platform in product(laws, platforms):
            model = models.load_model(name, law)
            yield partial(models.blank_library, model, 2, platform)
            yield partial(models.blank_library, model, 3, platform)


if __name__ == "__main__":
    print(precompile())
    if library := bokeh():
        print(atomic_write(CARRIED, library))
