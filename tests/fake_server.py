"""Servers on this computer that tests reach over WebSockets, and that come, go and hang."""

import asyncio
import json
import threading
from abc import ABC, abstractmethod
from contextlib import suppress
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

DEADLINE_S = 60.0
"""Time to wait for another thread before a test fails."""


class FakeServer(ABC):
    """A server on a thread of its own. Its port stays the same when it stops listening and starts
    again. Subclasses answer.

    Attributes:
        received: every message of a client, in order.
        connections: number of connections so far.
    """

    def __init__(self) -> None:
        self.port = 0
        self.received: list[dict[str, Any]] = []
        self.connections = 0
        self._clients: list[ServerConnection] = []
        self._tasks: set[asyncio.Task[None]] = set()
        self._loop = asyncio.new_event_loop()
        self._server: Any = None
        self._thread = threading.Thread(
            target=self._loop.run_forever, name=type(self).__name__, daemon=True
        )
        self._thread.start()
        self._thawed = threading.Event()
        self._thawed.set()

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.port}"

    def arrive(self) -> None:
        """Start to listen for connections."""
        self._do(self._listen())

    def leave(self) -> None:
        """Cut every connection, and refuse new ones."""
        self._do(self._shut())

    def freeze(self) -> None:
        """Hang as if the cable was pulled: connections stay open without data."""
        self._thawed.clear()
        self._loop.call_soon_threadsafe(self._thawed.wait)

    def thaw(self) -> None:
        """Continue after hanging."""
        self._thawed.set()

    def close(self) -> None:
        """Stop for good."""
        self.thaw()
        self.leave()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(DEADLINE_S)
        self._loop.close()

    def send(self, text: str) -> None:
        """Send raw data to all connections."""
        self._do(self._send(text))

    def has_clients(self) -> bool:
        """True if there is a connection."""
        return bool(self._clients)

    @abstractmethod
    async def answer(self, client: ServerConnection, said: dict[str, Any]) -> None:
        """Answer a message of a client."""

    def do_later(self, work: Any) -> "asyncio.Task[None]":
        """Do something beside answering, until it is done or the server leaves."""
        task: asyncio.Task[None] = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def _do(self, work: Any) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(DEADLINE_S)

    async def _listen(self) -> None:
        self._server = await serve(self._attend, "127.0.0.1", self.port)
        self.port = self._server.sockets[0].getsockname()[1]

    async def _shut(self) -> None:
        await self._cancel_tasks()
        if self._server is not None:
            for client in list(self._clients):
                client.transport.abort()
            self._server.close()
            await self._server.wait_closed()
            self._server = None
        await self._cancel_tasks()  # those of messages that had come before

    async def _cancel_tasks(self) -> None:
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _attend(self, client: ServerConnection) -> None:
        self.connections += 1
        self._clients.append(client)
        with suppress(ConnectionClosed):
            async for frame in client:
                said = json.loads(frame)
                self.received.append(said)
                await self.answer(client, said)
        self._clients.remove(client)
        self.left(client)

    def left(self, client: ServerConnection) -> None:  # noqa: B027 - most have nothing to forget
        """Forget a client."""

    async def tell(self, client: ServerConnection, message: dict[str, Any]) -> None:
        """Send a message to a client, who may be disconnecting."""
        with suppress(ConnectionClosed):
            await client.send(json.dumps(message))

    async def _send(self, text: str) -> None:
        for client in list(self._clients):
            await client.send(text)
