"""An event loop whose timers are precise to a fraction of a millisecond."""

import asyncio
import selectors
import sys


def punctual_loop() -> asyncio.AbstractEventLoop:
    """Return a new event loop.

    On Linux asyncio would wait with ``epoll``, whose time-outs are whole milliseconds: timers come
    1 to 2 ms late. The time-outs of ``select`` are microseconds. It takes file descriptors below
    1024 only; an app has some twenty.
    """
    if sys.platform == "linux":
        return asyncio.SelectorEventLoop(selectors.SelectSelector())
    return asyncio.new_event_loop()
