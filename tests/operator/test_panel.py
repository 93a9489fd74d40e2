"""Keys of the panel: what they send, and what the screen shows."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from textual.events import Key, Paste
from textual.widgets import Static

from sar_tui.link.peer import Connection
from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.messages import Role
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.keymap import FILE
from sar_tui.plugins import Catalogue
from sar_tui.widgets.agent import Agent
from tests.operator import panel_driver as b
from tests.operator.panel_driver import ANNA, PanelDriver
from tests.settle import settle


@asynccontextmanager
async def panel(
    catalogue: Catalogue, folder: Path, role: Role = "operator"
) -> AsyncIterator[PanelDriver]:
    async with b.open_panel(catalogue, folder, role=role, size=(100, 30)) as driver:
        yield driver


@pytest.fixture
async def driver(catalogue: Catalogue, tmp_path: Path) -> AsyncIterator[PanelDriver]:
    """An operator's panel at a running session."""
    async with panel(catalogue, tmp_path) as driver:
        yield driver


# --- proposals


async def test_one_key_decides_with_its_time_stamp_and_each_proposal_is_reported_as_seen_once(
    driver: PanelDriver,
) -> None:
    for number, key in enumerate(("enter", "x", "delete", "plus", "equals_sign", "minus")):
        await driver.propose(b.approval(f"p{number}"))
        await driver.press(key)
    assert driver.sent(t.DECISION) == [
        m.Decision(action="p0", verdict="accept", actor=ANNA),
        m.Decision(action="p1", verdict="veto", actor=ANNA),
        m.Decision(action="p2", verdict="veto", actor=ANNA),
        m.Decision(action="p3", verdict="edit", valence="positive", actor=ANNA),
        m.Decision(action="p4", verdict="edit", valence="neutral", actor=ANNA),
        m.Decision(action="p5", verdict="edit", valence="negative", actor=ANNA),
    ]
    at = [message.at for name, message in driver.peer.sent if name == t.DECISION.name][-1]
    assert driver.peer.now() - 5 * SECOND < at <= driver.peer.now()
    seen = [seen.action for seen in driver.sent(t.PROPOSAL_SEEN)]
    assert seen == [f"p{number}" for number in range(6)]


async def test_text_is_edited_in_place_unchanged_it_is_approved_and_escape_cancels(
    driver: PanelDriver,
) -> None:
    await driver.propose(b.approval("p1", text="Well done"))
    await driver.press("e", "!", "enter")
    await driver.propose(b.approval("p2"))
    await driver.press("e", "enter")
    await driver.propose(b.approval("p3"))
    await driver.press("e", "x", "escape")
    assert len(driver.sent(t.DECISION)) == 2
    await driver.press("x")
    assert driver.sent(t.DECISION) == [
        m.Decision(action="p1", verdict="edit", text="Well done!", actor=ANNA),
        m.Decision(action="p2", verdict="accept", actor=ANNA),
        m.Decision(action="p3", verdict="veto", actor=ANNA),
    ]


async def test_typed_text_never_acts_as_keys_and_an_edit_that_is_too_late_can_be_said(
    driver: PanelDriver,
) -> None:
    await driver.press("e", "s", "r", "space", "u", "enter")
    assert driver.sent(t.COMMAND) == []
    assert driver.sent(t.REMARK) == [m.Remark(text="sr u", source="free text", actor=ANNA)]
    await driver.propose(b.approval(text="Well done"))
    await driver.press("e", "!")
    await driver.propose()
    await driver.press("enter")
    assert driver.sent(t.DECISION) == []
    assert "Too late: it was already decided." in driver.text
    await driver.press("enter")
    assert driver.sent(t.REMARK)[1:] == [
        m.Remark(text="Well done!", source="free text", actor=ANNA)
    ]


async def test_a_level_has_no_valence_and_is_typed_again_until_the_session_can_have_it(
    driver: PanelDriver,
) -> None:
    await driver.propose(b.approval("d1", level=5, text="Level 4 → 5"))
    await driver.press("plus", "e", "backspace", "x", "enter")
    assert driver.sent(t.DECISION) == []
    await driver.press("backspace", "3", "enter")
    assert driver.sent(t.DECISION) == [m.Decision(action="d1", verdict="edit", level=3, actor=ANNA)]
    await driver.propose(b.approval("d2", 2000, level=5))
    await driver.press("e", "8")
    await driver.advance(2000)
    await driver.publish(t.ARBITER_STATE, b.arbiter_state(b.approval("p2", 9000)))
    await driver.press("enter", "enter")
    assert driver.sent(t.REMARK) == [], "only late words can be said anyway"


async def test_the_shown_proposal_stays_until_it_is_decided_and_a_key_right_after_is_not_for_the_next(
    driver: PanelDriver,
) -> None:
    first, second = b.approval("p1", 4000), b.approval("p2", 4000, text="Second")
    await driver.propose(first, second)
    assert "1 of 2" in driver.text
    urgent = b.approval("p3", 1500, text="Urgent")
    await driver.propose(urgent, first, second)
    assert "2 of 3" in driver.text
    assert "Also pending: 0 s feedback “Urgent”" in driver.text
    await driver.press("right")
    assert "┃ “Second”" in driver.text
    await driver.press("left")
    await driver.propose(second, urgent)  # the first is gone while it is shown
    await driver.press("right", "enter")
    assert driver.sent(t.DECISION) == []
    assert "Too soon" in driver.text
    await driver.advance(500)
    await driver.press("enter")
    assert [decision.action for decision in driver.sent(t.DECISION)] == ["p2"]


async def test_a_decided_proposal_makes_room_for_the_next_until_it_is_refused(
    driver: PanelDriver,
) -> None:
    await driver.propose(b.approval("p1"), b.approval("p2", text="Second"))
    await driver.press("enter")
    assert "“Second”" in driver.text
    await driver.advance(500)
    await driver.press("x", "x")
    assert driver.text.count("Vetoing feedback …") == 2, "instead of its keys, and in the log"
    await driver.answer("refused", "Too many at once.")
    await driver.press("enter")
    assert [(each.action, each.verdict) for each in driver.sent(t.DECISION)] == [
        ("p1", "accept"),
        ("p2", "veto"),
        ("p2", "accept"),
    ]


async def test_the_time_left_is_counted_down_for_each_proposal_and_for_what_is_approved(
    driver: PanelDriver,
) -> None:
    await driver.publish(
        t.ARBITER_STATE, b.arbiter_state(b.approval(ms=4000), b.approval("p2", ms=4000))
    )
    assert "acts by itself in 4.0 s" in driver.text
    full = driver.text.count("█")
    await driver.advance(2000)
    assert "acts by itself in 2.0 s" in driver.text
    left = driver.text.count("█")
    assert left < full
    await driver.press("right")
    assert driver.text.count("█") == left  # it has been counting down all the time
    due = b.action("a9", text="Well done", due=driver.peer.now() + 1900 * MS)
    await driver.publish(t.ARBITER_STATE, b.arbiter_state(queued=(due,)))
    await driver.advance(1000)
    assert "goes out in 0.9 s" in driver.text


# --- the session


async def test_single_keys_control_the_session(driver: PanelDriver) -> None:
    await driver.press("f2", "space")
    await driver.publish(t.WAITING, b.waiting())
    await driver.press("s", "r", "u", "d", "d")
    assert driver.sent(t.COMMAND) == [
        m.SessionCommand(command="stop", actor=ANNA),
        m.SessionCommand(command="pause", actor=ANNA),
        m.SessionCommand(command="skip", actor=ANNA),
        m.SessionCommand(command="repeat", actor=ANNA),
        m.SessionCommand(command="level", value=5, actor=ANNA),
        m.SessionCommand(command="level", value=4, actor=ANNA),
        m.SessionCommand(command="level", value=3, actor=ANNA),
    ]


async def test_pause_and_hold_toggle_and_end_asks_once(driver: PanelDriver) -> None:
    await driver.publish(t.COMMAND, m.SessionCommand(command="pause", actor="operator.ben"))
    await driver.publish(t.WAITING, b.waiting("resume", "paused"))
    assert "ben paused" in driver.text
    await driver.press("space", "end", "escape", "end")
    assert [act.command for act in driver.sent(t.COMMAND)] == ["resume"]
    await driver.press("end", "h")
    assert [act.command for act in driver.sent(t.COMMAND)] == ["resume", "end"]
    assert [each.mode for each in driver.sent(t.MODE)] == ["manual"]
    held = b.arbiter_state(modes={**b.MODES, "difficulty": "manual"})
    await driver.publish(t.ARBITER_STATE, held)
    assert "manual: difficulty" in driver.text


async def test_a_participants_pause_is_highlighted_and_ended_only_by_a_second_key(
    driver: PanelDriver,
) -> None:
    await driver.publish(t.COMMAND, m.SessionCommand(command="pause", reason="pain"))
    await driver.publish(t.WAITING, b.waiting("resume", "paused", reason="pain"))
    assert driver.text.count("P01 paused: in pain") == 2, "in the activity and in the log"
    await driver.press("space")
    await driver.advance(3200)
    driver.panel._clock.advance(3200 * MS)  # type: ignore[attr-defined]
    await driver.press("space")
    assert driver.sent(t.COMMAND) == []
    await driver.advance(1000)
    await driver.press("space")
    assert [act.command for act in driver.sent(t.COMMAND)] == ["resume"]


async def test_in_a_burst_of_keys_each_key_goes_to_what_the_one_before_opened(
    driver: PanelDriver,
) -> None:
    await driver.burst(
        "n", *"hurx", "backspace", "t", "enter", "t", *"Hi", "enter", "n", *"so", "enter", "h"
    )
    assert [note.text for note in driver.sent(t.NOTE_ADDED)] == ["hurt", "so"]
    assert [remark.text for remark in driver.sent(t.REMARK)] == ["Hi"]
    assert [each.mode for each in driver.sent(t.MODE)] == ["manual"]
    await driver.propose(b.approval(text="Well done"))
    await driver.burst("e", "!", "enter", "u")
    assert [each.text for each in driver.sent(t.DECISION)] == ["Well done!"]
    assert [act.command for act in driver.sent(t.COMMAND)] == ["level"]
    driver.app.post_message(Key("n", "n"))
    driver.app.post_message(Paste("pasted\nlines"))
    await driver.burst("enter")
    assert [note.text for note in driver.sent(t.NOTE_ADDED)][2:] == ["pasted"]


@pytest.mark.slow
async def test_an_edit_whose_time_runs_out_says_so_and_is_not_shown_with_the_next_proposal(
    driver: PanelDriver,
) -> None:
    await driver.propose(b.approval("p1", 2000, text="Well done"))
    await driver.press("e", "!")
    await driver.advance(2000)
    await driver.publish(t.ARBITER_STATE, b.arbiter_state(b.approval("p2", 9000, text="The next")))
    assert "Time is up: Well done!" in driver.text
    assert "Also pending: 6 s feedback “The next”" in driver.text
    assert "┃ “The next”" not in driver.text
    await driver.press("enter")
    assert driver.sent(t.DECISION) == []
    await driver.press("escape")
    assert "┃ “The next”" in driver.text
    assert "Time is up" not in driver.text


@pytest.mark.slow
async def test_while_the_panel_is_hidden_only_the_stop_key_acts(driver: PanelDriver) -> None:
    await driver.press("f1", "space", "u", "h", "1", "t", "x", "f2")
    assert [name for name, _ in driver.peer.sent] == [t.COMMAND.name]
    await driver.press("escape")
    await driver.pilot.resize_terminal(60, 16)
    await settle(driver.app)
    assert "This window is too small: it has 60 by 16 characters" in driver.text
    await driver.press("space", "f2")
    assert [act.command for act in driver.sent(t.COMMAND)] == ["stop", "stop"]
    for size in [(30, 5), (13, 24), (1, 1), (20, 200), (200, 1), (80, 24)]:
        await driver.pilot.resize_terminal(*size)
        await settle(driver.app)
    assert "too small" not in driver.text


# --- palette, speech, notes


async def test_numbers_choose_items_tab_turns_the_page_and_escape_goes_back(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    async with panel(catalogue, tmp_path) as driver:
        await driver.join(marks=b.MARKS)
        await driver.publish(
            t.ARBITER_STATE, b.arbiter_state(queued=(b.action("a9", text="Next."),))
        )
        await driver.press("1", "g", "4", "m", "2", "o", "5", "c", "1", "9")
        phrase, gesture = driver.sent(t.REMARK)
        assert (phrase.text, phrase.source) == (
            catalogue.theme("calm").phrases["encouragement"][0],
            "phrase",
        )
        assert gesture == m.Remark(gesture="wave", source="gesture", actor=ANNA)
        assert driver.sent(t.COMMAND) == [
            m.SessionCommand(command="mark", reason="assisted", actor=ANNA)
        ]
        assert driver.sent(t.MODE) == [m.ModeChanged(kind="difficulty", mode="approve", actor=ANNA)]
        assert driver.sent(t.DECISION) == [m.Decision(action="a9", verdict="veto", actor=ANNA)]
        await driver.press("escape")
        for key, page in (("tab", " 2/10"), ("shift+tab", " 1/10"), ("shift+tab", " 10/10")):
            await driver.press(key)
            assert page in driver.text
        await driver.press("escape")
        assert " 1/10" in driver.text


async def test_speech_notes_and_events_are_sent_and_a_note_has_the_time_of_its_key(
    driver: PanelDriver,
) -> None:
    await driver.press("t", *"Hi", "enter")
    await driver.answer("refused", "It comes too fast.")
    await driver.burst("t", "enter")
    await driver.press("t")
    assert driver.panel.strip.typed == "", "a text is offered again only if it was refused"
    await driver.press("escape", "n")
    await driver.advance(20_000)
    await driver.press(*"tired", "enter", "f5")
    assert driver.sent(t.REMARK) == [m.Remark(text="Hi", source="free text", actor=ANNA)] * 2
    assert driver.sent(t.NOTE_ADDED) == [
        m.NoteAdded(text="tired", actor=ANNA),
        m.NoteAdded(label="distracted", actor=ANNA),
    ]
    note = next(message for name, message in driver.peer.sent if name == t.NOTE_ADDED.name)
    assert note.at <= driver.peer.now() - 20 * SECOND


@pytest.mark.slow
async def test_with_two_participants_remarks_go_to_the_chosen_one_and_proposals_name_theirs(
    driver: PanelDriver,
) -> None:
    await driver.join(
        participants={"A": "P01", "B": "P02"}, spoken_names={"A": "Left", "B": "Right"}
    )
    assert "Encourage 1/10 · to P01 (a)" in driver.text
    await driver.press("a", "1", "t", *"Hi")
    assert "Say to P02: Hi" in driver.text
    await driver.press("enter")
    assert "Encourage 1/10 · to P02 (a)" in driver.text
    phrase, own = driver.sent(t.REMARK)
    assert (phrase.seat, own.seat, own.text) == ("B", "B", "Right: Hi")
    assert phrase.text.startswith("Right: ")
    await driver.propose(b.approval("p3", seat="B", text="Right: Well done"))
    assert "FEEDBACK to P02 · positive" in driver.text
    await driver.press("e")
    assert "Edit: Well done" in driver.text
    await driver.press("escape")
    await driver.propose(b.approval("l1", level=5))
    assert "DIFFICULTY · clear" in driver.text


@pytest.mark.slow
async def test_keys_and_phrases_of_the_operators_file_are_used_unless_it_is_invalid(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    file = 'phrases = ["Go on, {participant}."]\n[keys]\napprove = "y"\n'
    (tmp_path / FILE).write_text(file)
    async with panel(catalogue, tmp_path) as driver:
        await driver.propose(b.approval())
        await driver.press("enter")
        assert driver.sent(t.DECISION) == []
        await driver.press("y", "1")
        assert [decision.verdict for decision in driver.sent(t.DECISION)] == ["accept"]
        assert [remark.text for remark in driver.sent(t.REMARK)] == ["Go on, P01."]
    (tmp_path / FILE).write_text("[keys]\nstpo = 'y'\n")
    async with panel(catalogue, tmp_path) as driver:
        assert "is ignored" in driver.text
        await driver.press("f2")
        assert [act.command for act in driver.sent(t.COMMAND)] == ["stop"]


# --- operators and the link


async def test_an_observer_sees_the_same_but_can_only_stop_the_agent(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    async with panel(catalogue, tmp_path, "observer") as driver:
        await driver.propose(b.approval())
        assert "Well done." in driver.text
        assert "Encourage" not in driver.text
        await driver.press("enter", "x", "e", "plus", "space", "s", "u", "h", "1", "t", "n", "f5")
        await driver.press("b", "end", "end")
        assert driver.peer.sent == []
        assert driver.peer.control_requests == 0
        await driver.press("f1")
        assert "Skip prompt" not in driver.text
        await driver.press("f2")
        assert [act.command for act in driver.sent(t.COMMAND)] == ["stop"]


async def test_without_control_nothing_is_sent_until_it_is_taken(driver: PanelDriver) -> None:
    await driver.publish(t.PRESENCE, b.presence("baton", "operator.ben", ben="operator"))
    await driver.propose(b.approval())
    assert "ben decides; b takes control." in driver.text
    await driver.publish(t.WAITING, b.waiting())
    await driver.press("s", "t", "s")
    assert driver.peer.sent == []
    assert "ben has control; b takes it. Nothing was sent." in driver.text
    await driver.press("b")
    assert driver.peer.control_requests == 1
    await driver.publish(t.PRESENCE, b.presence("baton", ANNA, ben="operator"))
    await driver.press("s")
    assert [act.command for act in driver.sent(t.COMMAND)] == ["skip"]


async def test_a_lost_link_is_shown_until_it_is_back_and_the_session_says_which_theme_to_take(
    driver: PanelDriver, catalogue: Catalogue
) -> None:
    await driver.propose(b.approval())
    await driver.receive(Connection("lost", "Nothing is heard from the session."))
    assert "connection lost" in driver.text
    await driver.press("enter")
    assert driver.sent(t.DECISION) == []
    assert "calm" in driver.app.theme
    await driver.join()
    assert "● in control" in driver.text
    await driver.publish(t.THEME, m.ThemeApplied(theme=catalogue.theme("playful")))
    assert "playful" in driver.app.theme


@pytest.mark.slow
async def test_the_panel_shows_the_agent_as_the_participant_sees_it(driver: PanelDriver) -> None:
    await driver.publish(t.ACTION, b.action("a2", text="Look at that!"))
    assert "Look at that!" in driver.text
    assert driver.text.count("◠") == 2
    await driver.publish(
        t.ACTION, b.action("a3", text="And then " + "on " * 60 + "to the end.", joins=True)
    )
    assert "to the end." in driver.text
    assert "…" in "".join(row[:46] for row in driver.rows[2:9]), "cut text ends with an ellipsis"
    await driver.receive(b.TRACE)
    assert "rad/s" in driver.text
    await driver.publish(t.WAITING, b.waiting("foreperiod"))
    assert "to the end." not in driver.text
    ahead = driver.panel.query_one(Agent).query_one(".robot", Static).render()
    await driver.publish(t.CUE, b.cue())
    aside = driver.panel.query_one(Agent).query_one(".robot", Static).render()
    assert str(aside) != str(ahead)
    await driver.publish(t.WAITING, b.waiting("response"))
    assert str(driver.panel.query_one(Agent).query_one(".robot", Static).render()) == str(aside)
    await driver.publish(t.WAITING, b.waiting("quiet"))
    assert str(driver.panel.query_one(Agent).query_one(".robot", Static).render()) == str(ahead)


@pytest.mark.slow
async def test_at_80_by_24_all_keys_are_listed_stop_works_anywhere_and_other_proposals_are_named(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    async with b.open_panel(catalogue, tmp_path) as driver:
        await driver.press("t", "a", "f2", "escape", "f1")
        for first_or_last in ("Approve", "Take control", "Close what"):
            assert first_or_last in driver.text
        await driver.press("f2", "f1")
        assert [act.command for act in driver.sent(t.COMMAND)] == ["stop", "stop"]
        assert "Take control" not in driver.text
        wave = b.approval("p2", kind="gesture", text="", spoken="", gesture="wave")
        await driver.propose(b.approval("p1"), wave)
        assert "Also pending: 4 s gesture [wave]" in driver.text


async def test_leaving_asks_once_until_the_session_is_over(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    async with b.open_panel(catalogue, tmp_path, joins=False) as driver:
        await driver.receive(Connection("connecting", "The other side refuses."))
        assert "There is no connection yet: The other side refuses." in driver.text
        await driver.press("q", "escape", "ctrl+q")
        assert "Leave the panel?" in driver.text
        assert not driver.peer.is_closed
        await driver.press("ctrl+q")
        assert not driver.app.is_running
    async with panel(catalogue, tmp_path) as driver:
        await driver.publish(t.SESSION_ENDED, m.SessionEnded(status="completed"))
        await driver.receive(Connection("ended", "The session is over."))
        assert "The session is over. q leaves." in driver.text
        assert "no connection" not in driver.text
        await driver.press("q")
        assert driver.peer.is_closed
