"""Keep tests of the app independent of the developer's terminal and other sessions."""

import gc
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from tests.app.fake_voice import voice

__all__ = ["voice"]

_SIGNS = ("SSH_CONNECTION", "SSH_TTY", "SSH_CLIENT", "TMUX", "STY", "ZELLIJ", "NO_COLOR")


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
