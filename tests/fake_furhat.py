"""A fake Furhat: a server of its realtime API, as far as sar-tui uses it.

It answers as the package furhat-realtime-api 0.1.3 (MIT) expects: `test_furhat` has that client
speak, gesture and stop with this server where it is installed (``pip install --no-deps
furhat-realtime-api``).
"""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Literal

from websockets.asyncio.server import ServerConnection

from tests.fake_server import FakeServer

Manner = Literal["obliging", "silent", "slow", "failing", "muddled", "breaking off", "deaf"]


class FakeFurhat(FakeServer):
    """A Furhat.

    Args:
        manner: how it reacts to a request. ``obliging``: starts and completes it. ``silent``: never
            answers. ``slow``: starts it and never ends. ``failing``: answers with an error.
            ``muddled``: answers what is no event. ``breaking off``: starts to speak, then aborts.
            ``deaf``: as ``slow``, and does not stop.
        lasts_s: time that it takes to speak or to perform a gesture.
        key: the key that it wants; none if empty.
    """

    def __init__(self, manner: Manner = "obliging", lasts_s: float = 0.0, key: str = "") -> None:
        super().__init__()
        self.manner: Manner = manner
        self.lasts_s = lasts_s
        self.key = key
        self._speaking: dict[ServerConnection, asyncio.Event] = {}
        self._allowed: set[ServerConnection] = set()

    def events(self, kind: str) -> list[dict[str, Any]]:
        """Return the requests of a kind that were received."""
        return [said for said in list(self.received) if said["type"] == f"request.{kind}"]

    def is_ready(self) -> bool:
        """True if somebody is connected and has given the right key."""
        return bool(self._allowed)

    def left(self, client: ServerConnection) -> None:
        self._allowed.discard(client)

    async def answer(self, client: ServerConnection, said: dict[str, Any]) -> None:
        of = {"request_id": said["request_id"]} if "request_id" in said else {}
        if said["type"] == "request.auth":
            access = said.get("key", "") == self.key
            scope = "all" if access else "none"
            await self.tell(
                client, {"type": "response.auth", "access": access, "scope": scope} | of
            )
            if access:
                self._allowed.add(client)
        elif client in self._allowed:
            await self._do_as_told(client, said, of)

    async def _do_as_told(
        self, client: ServerConnection, said: dict[str, Any], of: dict[str, str]
    ) -> None:
        kind = said["type"].removeprefix("request.")
        if kind == "speak.stop" and self.manner not in ("silent", "deaf"):
            for stopped in self._speaking.values():
                stopped.set()
        elif kind not in ("speak.text", "gesture.start") or self.manner == "silent":
            pass
        elif self.manner == "failing":
            error = {"type": "response.error", "error": "My neck is\x1b[2J stuck."}
            await self.tell(client, error | of)
        elif self.manner == "muddled":
            for nonsense in ("tea", "[1, 2]", '{"type": 7}', '{"type": "response.speak.end", '):
                await client.send(nonsense)
            await self.tell(client, {"type": "response.speak.end", "request_id": "other"})
        elif kind == "speak.text":
            self.do_later(self._speak(client, said, of))
        elif said.get("monitor"):
            self.do_later(self._gesture(client, of))

    async def _speak(
        self, client: ServerConnection, said: dict[str, Any], of: dict[str, str]
    ) -> None:
        stopped = self._speaking[client] = asyncio.Event()
        about = {"text": said["text"]} | of
        await self.tell(client, {"type": "response.speak.start", "gen_time": 0} | about)
        waits = self.lasts_s if self.manner == "obliging" else None
        aborted = self.manner == "breaking off"
        if not aborted:
            with suppress(TimeoutError):
                aborted = await asyncio.wait_for(stopped.wait(), waits)
        await self.tell(client, {"type": "response.speak.end", "aborted": aborted} | about)

    async def _gesture(self, client: ServerConnection, of: dict[str, str]) -> None:
        await self.tell(client, {"type": "response.gesture.start"} | of)
        if self.manner == "obliging":
            await asyncio.sleep(self.lasts_s)
            await self.tell(client, {"type": "response.gesture.end"} | of)


@contextmanager
def furhat(
    manner: Manner = "obliging", lasts_s: float = 0.0, key: str = ""
) -> Iterator[FakeFurhat]:
    """Run a server until the end of the block."""
    server = FakeFurhat(manner, lasts_s, key)
    server.arrive()
    try:
        yield server
    finally:
        server.close()
