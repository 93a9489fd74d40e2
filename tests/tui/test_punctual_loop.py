"""Apps run on an event loop with precise timers."""

import asyncio
import selectors
from typing import Any

from sar_tui.tui.base_app import BaseApp

IN_WHOLE_MS = tuple(
    getattr(selectors, name)
    for name in ("EpollSelector", "PollSelector", "DevpollSelector")
    if hasattr(selectors, name)
)
"""Selectors that round the time until the next timer up to milliseconds."""


def test_an_app_runs_on_a_loop_that_does_not_wait_in_whole_milliseconds() -> None:
    loops: list[Any] = []

    class Noting(BaseApp):
        async def run_async(self, **how: Any) -> None:
            loops.append(asyncio.get_running_loop())

    assert Noting().run_here() == 0
    assert not isinstance(getattr(loops[0], "_selector", None), IN_WHOLE_MS)
