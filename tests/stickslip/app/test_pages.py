"""The workbench without a browser: what its pages show."""

import asyncio
from functools import partial

import pytest

from stickslip.app.jobs import Job
from stickslip.app.workbench import Workbench

testing = pytest.importorskip("nicegui.testing", reason="nicegui is not installed")


def opened(work, look):
    """Open the page of a workbench, and let a coroutine look at it."""
    from stickslip.app.pages import page

    async def see():
        async with testing.user_simulation(partial(page, work)) as user:
            await user.open("/")
            await look(user)

    asyncio.run(see())


@pytest.mark.parametrize("kind", ["learn", "tune", "arena"])
def test_a_page_shows_what_was_begun_in_another(tmp_path, kind):
    work = Workbench(tmp_path)
    for k in (1, 2):
        name = f"{kind}-axis-{k}"
        work.jobs[name] = Job(name, of=f"axis-{k}.csv", since="12:34", stages=["searching"])
    first, second = work.jobs.values()
    first.ended = True

    async def look(user):
        await user.should_see(f"{kind}-axis-2")
        await user.should_see("axis-2.csv, since 12:34")
        await user.should_see("searching", retries=20)
        await user.should_not_see(f"{kind}-axis-1")
        second.error, second.ended, second.version = "no friction is seen", True, 1
        await user.should_see("no friction is seen", retries=20)

    opened(work, look)
    if kind == "learn":  # that tab is open when nothing runs
        opened(work, lambda user: user.should_see("no friction is seen", retries=20))
