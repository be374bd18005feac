"""Settings of all tests, and the quick tier.

Tests interrupt runs, but a process that xdist, nohup or a shell starts aside ignores signals.
A busy machine may take any time for one example of Hypothesis, so examples have no deadline.
Linear algebra has one thread, as in the commands; processes side by side wait for each other's.
Compiled modules are kept: hundreds of processes start, and compiling takes most of their start.
"""

import gc
import os
import signal
import sys
from collections import Counter
from collections.abc import Generator
from pathlib import Path

import pytest
import scipy.linalg  # noqa: F401  (its library must be loaded to be limited)
from hypothesis import settings
from threadpoolctl import threadpool_limits

HERE = Path(__file__).parent
FIRST = (
    *("examples/test_notebooks", "examples/test_pages", "stickslip/papers/lugre/test_results"),
    *("stickslip/studies/arena/test_arena", "stickslip/identification/test_measured_logs"),
    *("stickslip/studies/learn/test_learn_command", "stickslip/studies/tune/test_tune_drive"),
)
"""Files that take longest, so that none of them is left to the end."""
CASES = 1
"""Of each test in a folder that has parameters, so many cases belong to the quick tier."""

for name in ("SIGINT", "SIGHUP"):
    if (number := getattr(signal, name, None)) and signal.getsignal(number) is signal.SIG_IGN:
        default = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
        signal.signal(number, default)

os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

threadpool_limits(limits=1, user_api="blas")

settings.register_profile("stickslip", deadline=None)
settings.load_profile("stickslip")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add --quick."""
    parser.addoption(
        "--quick",
        action="store_true",
        help=f"run at most {CASES} case of each test, and none that is marked slow",
    )


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect no garbage while tests are collected, of which all stay."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put what takes longest first, and leave what the quick tier does not run."""
    long = {HERE / f"{name}.py" for name in FIRST}
    items.sort(key=lambda item: item.path not in long)
    if not config.getoption("--quick"):
        return
    taken: Counter[str] = Counter()
    kept, left = [], []
    for item in items:
        test = item.nodeid.partition("[")[0]
        taken[test] += 1
        few = taken[test] <= CASES or item.path.parent == HERE
        quick = few and item.get_closest_marker("slow") is None
        (kept if quick else left).append(item)
    config.hook.pytest_deselected(items=left)
    items[:] = kept


def pytest_collection_finish() -> None:
    """Let the garbage collector pass over thousands of tests, which stay until the end."""
    gc.freeze()


@pytest.fixture(params=[2, 3], ids=["FMI 2.0", "FMI 3.0"])
def version(request: pytest.FixtureRequest) -> int:
    """Give both versions of the standard in turn."""
    return request.param
