"""Session that operators can join, with a fake channel to the broker process."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import msgspec
import pytest

from sar_tui.link import protocol
from sar_tui.link.broker_process import OutgoingBatch, OutgoingSnapshot
from sar_tui.link.errors import LinkError
from sar_tui.link.listening import ListenOptions
from sar_tui.link.protocol import ActReceived, PeerJoined, SnapshotRequested
from sar_tui.loop.topics import COMMAND, PROMPT, SHOWN, THEME
from sar_tui.model import messages as m
from tests.app.app_driver import OpenApp, OpenSession, known, stored
from tests.link.test_node import ANNA, FakeChannel


@pytest.fixture
def channel() -> FakeChannel:
    return FakeChannel()


async def test_operator_sees_the_session(open_session: OpenSession, channel: FakeChannel) -> None:
    async with open_session(link=channel) as driver:
        channel.notify(PeerJoined(ANNA))
        channel.notify(SnapshotRequested(ANNA))
        await driver.wait(100)
        (snapshot,) = (sent for sent in channel.sent if isinstance(sent, OutgoingSnapshot))
        welcome = snapshot.welcome
        found = (welcome.session, welcome.link, welcome.task)
        assert found == (driver.session_id, channel.link, "keyboard")
        assert (welcome.participants, welcome.attempts, welcome.trials) == ({"A": "P01"}, 2, 2)
        assert driver.app.live
        assert driver.app.live._peers
        assert driver.app.live._peers.trial_mark() == driver.session.trial_mark
        assert THEME in [record.topic for record in snapshot.records]

        await driver.to_first_prompt()
        await driver.wait(1000)
        topics = [
            record.topic
            for sent in channel.sent
            if isinstance(sent, OutgoingBatch)
            for record in sent.records
        ]
        assert topics.index(PROMPT) < topics.index(SHOWN)


async def test_who_ends_it_is_recorded(open_session: OpenSession, channel: FakeChannel) -> None:
    async with open_session(link=channel) as driver:
        channel.notify(PeerJoined(ANNA))
        channel.notify(
            ActReceived(
                ANNA, COMMAND.name, msgspec.Raw(protocol.encode(m.SessionCommand(command="end")))
            )
        )
        await driver.wait(1000)
        assert driver.session.ended
        assert [(act["command"], act["actor"]) for act in driver.messages(COMMAND.name)] == [
            ("end", ANNA)
        ]
        assert any(
            f"sar-tui report wizard {driver.session_id}" in words
            for words in driver.app.leaving.lines(0)
        )
    assert driver.stored("SELECT status FROM sessions") == [("aborted",)]


class Links:
    """Counts the links that are opened, and closed."""

    def __init__(self, channel: FakeChannel) -> None:
        self.channel = channel
        self.opened: list[tuple[str, str, tuple[str, ...], ListenOptions, int]] = []
        self.closed = 0
        self.error = ""

    @contextmanager
    def open(
        self,
        _: Path,
        session: str,
        task: str,
        participants: Sequence[str],
        listening: ListenOptions,
        lost_ms: int,
    ) -> Iterator[FakeChannel]:
        if self.error:
            raise LinkError(self.error)
        self.opened.append((session, task, tuple(participants), listening, lost_ms))
        yield self.channel
        self.closed += 1


@pytest.fixture
def links(channel: FakeChannel, monkeypatch: pytest.MonkeyPatch) -> Links:
    links = Links(channel)
    monkeypatch.setattr("sar_tui.link.listening.open_link", links.open)
    return links


async def test_sessions_can_be_joined_if_set(opened: OpenApp, data: Path, links: Links) -> None:
    known(data, operator_joins=True, operator_lost_ms=700)
    here_only = ListenOptions(operator=True, end=None)
    async with opened() as driver:
        await driver.press("enter", "enter")
        links.channel.notify(PeerJoined(ANNA))
        await driver.wait(100)
        session = driver.session_id
        links.channel.notify(SnapshotRequested(ANNA))
        await driver.wait(100)
        assert any(isinstance(sent, OutgoingSnapshot) for sent in links.channel.sent)
        found = (links.opened, links.closed)
        assert found == ([(session, "keyboard", ("P01",), here_only, 700)], 0)
        driver.app.exit()
    assert links.closed == 1
    async with opened() as driver:
        driver.app.begin_session(session)
        await driver.settle()
        assert [opened[0] for opened in links.opened] == [session, session]
        driver.app.live.operate(m.SessionCommand(command="end"))
        await driver.wait(3000)
        await driver.press("enter")
        assert (driver.screen_name, links.closed) == ("HomeScreen", 2)


async def test_a_planned_operator_must_join(opened: OpenApp, data: Path, links: Links) -> None:
    known(data, operator_joins=True)
    links.error = "The link's process cannot be started."
    async with opened() as driver:
        await driver.press("enter", "enter")
        assert driver.screen_name == "HomeScreen"
        driver.see("cannot be started")
    assert stored(data, "SELECT count(*) FROM sessions") == [(0,)]
