"""The operator's protocol on the panel: one line, one key, and a reason that nobody must give."""

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.commands import REASON_FOR
from sar_tui.operator.phrases import PHRASE_KEYS
from sar_tui.plugins import Catalogue
from sar_tui.rules.protocol_file import parse
from sar_tui.store.interface_language import choose_interface_language
from tests.operator import panel_driver as b

SOURCE = b"""
name = "praise"
version = 2
phrases = ["You reached level {level}."]

[[steps]]
at = "start"
do = "say greeting"

[[steps]]
at = "after attempt 9"
do = "Offer them some water."

[[rules]]
when = "accuracy < 60 % twice"
do = "say phrase 1"

[[rules]]
when = "success = no"
do = "veto feedback"
"""
PROTOCOL = parse(SOURCE, PHRASE_KEYS)


def due(id: str, what: Any, number: int, **more: Any) -> m.ProtocolDue:
    item: Any = (PROTOCOL.steps if what == "step" else PROTOCOL.rules)[number - 1]
    fields = {"attempt": 3, "do": item.do, "at": b.START - SECOND, **more}
    return m.ProtocolDue(id=id, what=what, number=number, **fields)


@pytest.fixture
async def panel(catalogue: Catalogue, tmp_path: Path) -> AsyncIterator[b.PanelDriver]:
    async with b.open_panel(catalogue, tmp_path, protocol=PROTOCOL) as driver:
        yield driver


async def follow(panel: b.PanelDriver, *dues: m.ProtocolDue) -> None:
    """Let the session follow the protocol, and some of it be due."""
    await panel.publish(t.PROTOCOL, m.ProtocolChosen(protocol=PROTOCOL, actor=b.ANNA))
    for each in dues:
        await panel.publish(t.PROTOCOL_DUE, each)


async def test_the_protocol_is_sent_once_with_its_hash(panel: b.PanelDriver) -> None:
    await panel.publish(t.ACTING, m.AgentActing(acting=False))
    (chosen,) = panel.sent(t.PROTOCOL)
    assert (chosen.protocol.name, chosen.protocol.hash) == ("praise", PROTOCOL.hash)
    await panel.answer()
    assert "✓ Protocol: praise 2" in panel.text


async def test_a_snapshot_that_is_older_than_the_choice_does_not_repeat_it(
    panel: b.PanelDriver,
) -> None:
    """Panels ask for a snapshot until one comes, so that a slow session sends several."""
    await panel.join()
    assert len(panel.sent(t.PROTOCOL)) == 1
    await panel.receive(b.Connection("lost"))
    await panel.join()
    assert len(panel.sent(t.PROTOCOL)) == 1
    await panel.answer("refused", "It did not arrive.")
    assert len(panel.sent(t.PROTOCOL)) == 2


async def test_a_new_run_of_the_session_is_sent_it_again(panel: b.PanelDriver) -> None:
    await panel.join(run="another")
    assert len(panel.sent(t.PROTOCOL)) == 2


async def test_a_session_that_follows_it_is_sent_nothing(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    async with b.open_panel(catalogue, tmp_path, protocol=PROTOCOL, joins=False) as driver:
        known = b.frame(t.PROTOCOL, m.ProtocolChosen(protocol=PROTOCOL))
        await driver.receive(b.Connection("connected"), b.welcome())
        await driver.receive([known, *b.session_frames(catalogue.theme("calm"))])
        assert driver.sent(t.PROTOCOL) == []


async def test_a_protocol_for_other_units_is_not_used(catalogue: Catalogue, tmp_path: Path) -> None:
    other = parse(SOURCE.replace(b"success = no", b"metric > 3 cm"), PHRASE_KEYS)
    async with b.open_panel(catalogue, tmp_path, protocol=other) as driver:
        assert driver.sent(t.PROTOCOL) == []
        assert "The protocol is not used: results are in ms" in driver.text


async def test_an_observer_sends_no_protocol(catalogue: Catalogue, tmp_path: Path) -> None:
    async with b.open_panel(catalogue, tmp_path, role="observer", protocol=PROTOCOL) as driver:
        assert driver.sent(t.PROTOCOL) == []


async def test_one_line_shows_what_is_next_and_what_is_due(panel: b.PanelDriver) -> None:
    assert "Offer them" not in panel.text
    await follow(panel)
    assert "Next, after attempt 9: Offer them some water." in panel.text
    await panel.publish(t.PROTOCOL_DUE, due("d1", "rule", 1))
    await panel.publish(t.PROTOCOL_DUE, due("d2", "step", 2))
    row = next(row for row in panel.rows if "▶ say" in row)
    assert "▶ say “You reached level {level}.” (accuracy < 60 % twi… +1 k tick l leave out" in row
    await panel.publish(t.PROTOCOL_TICKED, m.ProtocolTicked(due="d1", outcome="done"))
    await panel.publish(t.PROTOCOL_TICKED, m.ProtocolTicked(due="d2", outcome="done"))
    assert "Protocol praise 2: no step is to come." in panel.text


async def test_one_key_says_the_phrase_and_ticks(panel: b.PanelDriver) -> None:
    await follow(panel, due("d1", "rule", 1))
    await panel.press("k")
    (remark,) = panel.sent(t.REMARK)
    assert remark.text == "You reached level 4."
    (tick,) = panel.sent(t.PROTOCOL_TICKED)
    act = next(act for name, act in panel.peer.sent if name == t.REMARK.name)
    assert (tick.due, tick.outcome, tick.act) == ("d1", "done", act.id)


async def test_a_phrase_of_the_theme_changes_with_the_attempts(panel: b.PanelDriver) -> None:
    await follow(panel, *(due(f"d{n}", "step", 1, attempt=n) for n in (0, 1)))
    await panel.press("k")
    await panel.publish(t.PROTOCOL_TICKED, m.ProtocolTicked(due="d0", outcome="done"))
    await panel.advance(200)
    await panel.press("k")
    texts = [remark.text for remark in panel.sent(t.REMARK)]
    theme = panel.panel.commands.state.theme
    assert theme
    assert texts == [text.replace("{{", "{") for text in theme.phrases["greeting"][:2]]


async def test_what_only_a_person_can_do_is_only_ticked(panel: b.PanelDriver) -> None:
    await follow(panel, due("d1", "step", 2))
    await panel.press("k")
    assert [(tick.due, tick.act) for tick in panel.sent(t.PROTOCOL_TICKED)] == [("d1", "")]
    assert panel.sent(t.REMARK) == []


async def test_what_cannot_be_done_is_not_ticked(panel: b.PanelDriver) -> None:
    await follow(panel, due("d1", "rule", 1, do="level 12"))
    await panel.press("k")
    assert "Level 10 is the highest level" in panel.text
    assert panel.sent(t.PROTOCOL_TICKED) == []


async def test_what_a_rule_says_is_for_the_participant_whose_result_it_is(
    panel: b.PanelDriver,
) -> None:
    await panel.join(participants={"A": "P01", "B": "P02"})
    await follow(panel, due("d1", "rule", 1, seat="B"))
    await panel.press("k")
    assert [remark.seat for remark in panel.sent(t.REMARK)] == ["B"]


async def test_another_key_says_that_it_is_not_done(panel: b.PanelDriver) -> None:
    await follow(panel, due("d1", "rule", 1))
    await panel.press("l")
    assert [tick.outcome for tick in panel.sent(t.PROTOCOL_TICKED)] == ["not done"]
    assert panel.sent(t.REMARK) == []


async def test_a_pending_proposal_is_vetoed_by_the_tick(panel: b.PanelDriver) -> None:
    await follow(panel, due("d1", "rule", 2), due("d2", "rule", 2))
    await panel.propose(b.approval("p1"))
    await panel.press("k")
    assert [(one.action, one.verdict) for one in panel.sent(t.DECISION)] == [("p1", "veto")]
    assert "Why?" not in panel.text, "the protocol is the reason"
    await panel.publish(t.PROTOCOL_TICKED, m.ProtocolTicked(due="d1", outcome="done"))
    await panel.publish(t.ARBITER_STATE, b.arbiter_state())
    await panel.advance(200)
    await panel.press("k")
    assert len(panel.sent(t.DECISION)) == 1, "nothing waits any more: it is only ticked"
    assert [tick.due for tick in panel.sent(t.PROTOCOL_TICKED)] == ["d1", "d2"]


async def test_a_key_that_was_on_its_way_ticks_nothing(panel: b.PanelDriver) -> None:
    await follow(panel)
    await panel.press("k")
    assert "Nothing is due by a protocol." in panel.text
    await panel.publish(t.PROTOCOL_DUE, due("d1", "rule", 1, at=b.START - 10 * MS))
    await panel.press("k")
    assert "Too soon" in panel.text
    assert panel.sent(t.PROTOCOL_TICKED) == []


async def test_a_key_that_is_held_does_one_thing(panel: b.PanelDriver) -> None:
    await follow(panel, due("d1", "rule", 1), due("d2", "rule", 1))
    await panel.press("k")
    await panel.advance(200)
    await panel.press("k")
    assert len(panel.sent(t.REMARK)) == 1, "the tick is on its way"


async def test_a_key_that_bounces_leaves_what_is_due_next(panel: b.PanelDriver) -> None:
    await follow(panel, due("d1", "rule", 1), due("d2", "rule", 1))
    await panel.press("k")
    await panel.publish(t.PROTOCOL_TICKED, m.ProtocolTicked(due="d1", outcome="done"))
    await panel.press("k")
    assert "Too soon" in panel.text, "nobody can have read it"
    assert [tick.due for tick in panel.sent(t.PROTOCOL_TICKED)] == ["d1"]


async def test_a_digit_as_the_question_ends_is_still_a_reason(panel: b.PanelDriver) -> None:
    await follow(panel)
    await veto(panel)
    await panel.advance(REASON_FOR // MS - 100)
    assert "Why?" not in panel.text
    await panel.press("1")
    assert [given.digit for given in panel.sent(t.REASON)] == [1]
    assert panel.sent(t.REMARK) == []


async def veto(panel: b.PanelDriver, id: str = "p1") -> None:
    await panel.propose(b.approval(id))
    await panel.press("x")
    await panel.publish(t.ARBITER_STATE, b.arbiter_state())


async def test_a_digit_after_a_veto_is_its_reason(panel: b.PanelDriver) -> None:
    await follow(panel)
    await veto(panel)
    assert "Why? A digit, if you like" in panel.text
    assert "3 participant upset" in panel.text
    await panel.press("7")
    assert "There is no reason 7." in panel.text
    await panel.press("3")
    given = m.ReasonGiven(
        action="p1", verdict="veto", digit=3, text="participant upset", actor=b.ANNA
    )
    assert panel.sent(t.REASON) == [given]
    await panel.press("1")
    assert len(panel.sent(t.REMARK)) == 1, "then digits choose from the palette again"


async def test_an_edit_asks_too(panel: b.PanelDriver) -> None:
    await follow(panel)
    await panel.propose(b.approval("p1"))
    await panel.press("minus", "2")
    assert [(one.verdict, one.digit) for one in panel.sent(t.REASON)] == [("edit", 2)]


@pytest.mark.slow
@pytest.mark.parametrize("ends", ["n", "u", "p", "escape", "time"])
async def test_the_next_act_another_page_or_time_end_the_question(
    panel: b.PanelDriver, ends: str
) -> None:
    await follow(panel)
    await veto(panel)
    if ends == "time":
        await panel.advance(REASON_FOR // MS + 1)
    else:
        await panel.press(ends, *(["x", "enter"] if ends == "n" else []))
    assert "Why?" not in panel.text
    await panel.press("1")
    assert panel.sent(t.REASON) == []
    assert len(panel.sent(t.REMARK)) == 1


async def test_without_a_protocol_nobody_is_asked(catalogue: Catalogue, tmp_path: Path) -> None:
    async with b.open_panel(catalogue, tmp_path) as driver:
        await veto(driver)
        assert "Why?" not in driver.text


@pytest.mark.parametrize("code", ["de", "es"])
async def test_the_line_and_the_reasons_are_in_the_panels_language(
    catalogue: Catalogue, tmp_path: Path, code: str
) -> None:
    choose_interface_language(tmp_path, code)
    async with b.open_panel(catalogue, tmp_path, protocol=PROTOCOL) as driver:
        await follow(driver)
        assert "Next" not in driver.text
        await veto(driver)
        assert "Why" not in driver.text
        assert "wrong moment" not in driver.text
        await driver.publish(t.PROTOCOL_DUE, due("d1", "step", 2))
        row = next(row for row in driver.rows if "▶ Offer" in row)
        assert "tick" not in row
        assert "attempt" not in row
