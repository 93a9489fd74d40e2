"""A session that operators may join: what they are told, and what they can do. The link's process is a stand-in."""

from pathlib import Path

import msgspec

from sar_tui.framework import messages as m
from sar_tui.framework.task import Task
from sar_tui.framework.topics import OPERATOR, PROMPT, SHOWN, THEME
from sar_tui.link import protocol
from sar_tui.link.channel import OutgoingBatch, OutgoingSnapshot
from sar_tui.link.protocol import ActReceived, PeerJoined, SnapshotRequested
from sar_tui.plugins import Catalogue
from tests.app.app_driver import plan, sit_down, stored
from tests.link.test_node import ANNA, Channel


async def test_an_operator_who_joins_is_told_of_the_session_and_sees_its_prompts(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    channel = Channel()
    async with sit_down(data, catalogue, plan(keyboard), link=channel) as driver:
        channel.hear(PeerJoined(ANNA))
        channel.hear(SnapshotRequested(ANNA))
        await driver.wait(100)
        (greeting,) = (sent for sent in channel.sent if isinstance(sent, OutgoingSnapshot))
        welcome = greeting.welcome
        assert (welcome.session, welcome.link, welcome.task) == (driver.session_id, channel.link, "keyboard")
        assert (welcome.participants, welcome.attempts, welcome.trials) == ({"A": "P01"}, 2, 2)
        assert THEME in [record.topic for record in greeting.records]

        await driver.to_first_prompt()
        await driver.wait(1000)
        told = [record.topic for sent in channel.sent if isinstance(sent, OutgoingBatch) for record in sent.records]
        assert told.index(PROMPT) < told.index(SHOWN)


async def test_an_operator_who_ends_the_session_is_in_its_record_by_name(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    channel = Channel()
    async with sit_down(data, catalogue, plan(keyboard), link=channel) as driver:
        channel.hear(PeerJoined(ANNA))
        channel.hear(ActReceived(ANNA, OPERATOR.name, msgspec.Raw(protocol.encode(m.Operator(command="end")))))
        await driver.wait(1000)
        assert driver.session.ended
        assert [(act["command"], act["actor"]) for act in driver.messages(OPERATOR.name)] == [("end", ANNA)]
        assert any(f"sar-tui report wizard {driver.session_id}" in words for words in driver.app.exit_lines(0))
    assert stored(data, "SELECT status FROM sessions") == [("aborted",)]
