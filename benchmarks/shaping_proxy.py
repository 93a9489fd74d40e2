"""TCP proxy that delays what it passes on, and stalls: a line from a home, in a process of its own.

Run it as ``python -m benchmarks.shaping_proxy PORT TO_PORT ROUND_TRIP_MS STALL_MS EVERY_MS``. It
listens on PORT of 127.0.0.1 and connects to TO_PORT there. Each direction is delayed by half of the
round trip. Each EVERY_MS nothing passes for STALL_MS, as after a lost packet, until it is sent
again.
"""

import asyncio
import contextlib
import sys
from typing import NamedTuple

_CHUNK = 65536


class Line(NamedTuple):
    """Delay of each direction, and stalls (s)."""

    delay: float
    stall: float
    every: float

    def due(self, now: float) -> float:
        """Return when something arrives that is sent at ``now``."""
        due = now + self.delay
        into = due % self.every if self.stall else self.stall
        return due + self.stall - into if into < self.stall else due


async def _pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, line: Line) -> None:
    """Pass on one direction, in order, until it ends."""
    loop = asyncio.get_running_loop()
    passing: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()

    async def deliver() -> None:
        while True:
            due, data = await passing.get()
            await asyncio.sleep(max(0.0, due - loop.time()))
            if not data:
                break
            writer.write(data)
            await writer.drain()

    delivering = asyncio.create_task(deliver())
    try:
        while data := await reader.read(_CHUNK):
            passing.put_nowait((line.due(loop.time()), data))
    except OSError:
        pass
    passing.put_nowait((line.due(loop.time()), b""))
    with contextlib.suppress(OSError):
        await delivering
    writer.close()


async def _serve(port: int, to: int, line: Line) -> None:
    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            there = await asyncio.open_connection("127.0.0.1", to)
        except OSError:
            writer.close()
            return
        await asyncio.gather(_pass_on(reader, there[1], line), _pass_on(there[0], writer, line))

    server = await asyncio.start_server(connected, "127.0.0.1", port)
    async with server:
        await server.serve_forever()


if __name__ == "__main__":
    port, to, *times = map(int, sys.argv[1:])
    round_trip, stall, every = (each / 1000 for each in times)
    asyncio.run(_serve(port, to, Line(round_trip / 2, stall, every)))
