"""Keep tests of the app independent of the developer's terminal and other sessions."""

import functools
import gc
from collections.abc import AsyncIterator, Iterator
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Plan
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, known, open_app, plan
from tests.app.fake_voice import voice

__all__ = ["voice"]

_HOW = ("size", "link", "patient", "markers", "sync_flash")
"""Arguments of `open_app`; the others are those of `plan`."""
_SIGNS = ("SSH_CONNECTION", "SSH_TTY", "SSH_CLIENT", "TMUX", "STY", "ZELLIJ", "NO_COLOR")


@pytest.fixture
def opened(data: Path, catalogue: Catalogue) -> OpenApp:
    return functools.partial(open_app, data, catalogue)


@pytest.fixture
def open_session(opened: OpenApp, catalogue: Catalogue, keyboard: type[Task]) -> OpenSession:
    def open_planned(**given: Any) -> AbstractAsyncContextManager[AppDriver]:
        how = {name: given.pop(name) for name in _HOW if name in given}
        return opened(plan(catalogue, keyboard, **given), **how)

    return open_planned


@pytest.fixture
def open_task(data: Path) -> OpenSession:
    """Open a session of the task in a folder, with these parameters."""

    def open_planned(folder: Path, **parameters: Any) -> AbstractAsyncContextManager[AppDriver]:
        catalogue = Catalogue(tasks=(folder.parent,))
        task = catalogue.task(folder.name)
        planned = Plan(task, build(task.Parameters, parameters), "calm", "P01", seed=7)
        return open_app(data, catalogue, planned)

    return open_planned


@pytest.fixture
async def driver(open_session: OpenSession) -> AsyncIterator[AppDriver]:
    """A short session of the keyboard task, on its instructions."""
    async with open_session() as driver:
        yield driver


@pytest.fixture
async def first_run(opened: OpenApp) -> AsyncIterator[AppDriver]:
    """The home screen before anybody trains."""
    async with opened() as driver:
        yield driver


@pytest.fixture
async def home(data: Path, opened: OpenApp) -> AsyncIterator[AppDriver]:
    """The home screen with the participant P01, who has settings for the keyboard task."""
    known(data, "P01")
    async with opened() as driver:
        yield driver


@pytest.fixture(autouse=True)
def a_plain_terminal() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for name in _SIGNS:
            patch.delenv(name, raising=False)
        yield


@pytest.fixture(autouse=True)
def no_session_to_join(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hide sessions that run on this machine, which the first screen lists."""
    monkeypatch.setattr("sar_tui.link.discovery.live_sessions", list)


@pytest.fixture(autouse=True)
def no_collection(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip garbage collection around attempts, which is slow with the memory of a test run."""
    skipped = SimpleNamespace(
        collect=int,
        freeze=int,
        unfreeze=int,
        enable=gc.enable,
        disable=gc.disable,
        isenabled=gc.isenabled,
    )
    monkeypatch.setattr("sar_tui.tui.gc_control.gc", skipped)
