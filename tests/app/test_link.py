"""Session that operators can join, with a fake channel to the broker process."""

from pathlib import Path

import msgspec
import pytest

from sar_tui.framework import messages as m
from sar_tui.framework.task import Task
from sar_tui.framework.topics import COMMAND, PROMPT, SHOWN, THEME
from sar_tui.link import protocol
from sar_tui.link.channel import OutgoingBatch, OutgoingSnapshot
from sar_tui.link.peer import Frame
from sar_tui.link.protocol import ActReceived, PeerJoined, SnapshotRequested
from sar_tui.operator.session_state import SessionState
from sar_tui.plugins import Catalogue
from tests.app.app_driver import open_app, plan, stored
from tests.link.test_node import ANNA, FakeChannel


@pytest.fixture
def channel() -> FakeChannel:
    return FakeChannel()


async def test_operator_gets_a_snapshot_and_sees_prompts(
    data: Path, catalogue: Catalogue, keyboard: type[Task], channel: FakeChannel
) -> None:
    async with open_app(data, catalogue, plan(catalogue, keyboard), link=channel) as driver:
        channel.notify(PeerJoined(ANNA))
        channel.notify(SnapshotRequested(ANNA))
        await driver.wait(100)
        (snapshot,) = (sent for sent in channel.sent if isinstance(sent, OutgoingSnapshot))
        welcome = snapshot.welcome
        assert (welcome.session, welcome.link, welcome.task) == (driver.session_id, channel.link, "keyboard")
        assert (welcome.participants, welcome.attempts, welcome.trials) == ({"A": "P01"}, 2, 2)
        assert driver.app.live
        assert driver.app.live._peers
        assert driver.app.live._peers.trial_mark() == driver.session.trial_mark
        assert THEME in [record.topic for record in snapshot.records]

        await driver.to_first_prompt()
        await driver.wait(1000)
        topics = [record.topic for sent in channel.sent if isinstance(sent, OutgoingBatch) for record in sent.records]
        assert topics.index(PROMPT) < topics.index(SHOWN)


async def test_operator_who_ends_the_session_is_recorded_by_name(
    data: Path, catalogue: Catalogue, keyboard: type[Task], channel: FakeChannel
) -> None:
    async with open_app(data, catalogue, plan(catalogue, keyboard), link=channel) as driver:
        channel.notify(PeerJoined(ANNA))
        channel.notify(ActReceived(ANNA, COMMAND.name, msgspec.Raw(protocol.encode(m.SessionCommand(command="end")))))
        await driver.wait(1000)
        assert driver.session.ended
        assert [(act["command"], act["actor"]) for act in driver.messages(COMMAND.name)] == [("end", ANNA)]
        assert any(f"sar-tui report wizard {driver.session_id}" in words for words in driver.app.exit_lines(0))
    assert stored(data, "SELECT status FROM sessions") == [("aborted",)]


async def test_a_panel_knows_the_outputs_and_hears_that_they_are_still(
    data: Path, catalogue: Catalogue, keyboard: type[Task], channel: FakeChannel
) -> None:
    async with open_app(data, catalogue, plan(catalogue, keyboard), link=channel) as driver:
        channel.notify(PeerJoined(ANNA))
        channel.notify(SnapshotRequested(ANNA))
        await driver.wait(100)
        (snapshot,) = (sent for sent in channel.sent if isinstance(sent, OutgoingSnapshot))
        state = SessionState().receive(snapshot.welcome).receive([Frame(*record) for record in snapshot.records])
        assert state.outputs == {"screen"}
        await driver.press("f2")
        await driver.wait(1000)
        records = [record for sent in channel.sent if isinstance(sent, OutgoingBatch) for record in sent.records]
        (stop,) = state.receive([Frame(*record) for record in records]).stops
        assert (stop.by, stop.awaited, stop.outcome(0)[1]) == ("P01 pressed F2", frozenset(), "good")
