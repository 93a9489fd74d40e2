"""The agent on the screen: what moves, when, and when nothing does."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from textual.app import App, ComposeResult
from textual.pilot import Pilot

from sar_tui.framework.clock import MS, SECOND, VirtualClock
from sar_tui.framework.gesture import Gesture, Keyframe
from sar_tui.framework.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.widgets.agent import FRAME, MOUTH, Agent

ARMS_UP = Gesture((Keyframe(at_ms=400, left_arm=1, right_arm=1), Keyframe(at_ms=1000)))


class Room:
    """An agent alone on a screen, and the clock that it moves by."""

    def __init__(self, theme: Theme) -> None:
        self.clock = VirtualClock()
        self.agent = Agent(theme, self.clock)
        self.pilot: Pilot[None]

    @property
    def drawing(self) -> list[str]:
        return str(self.agent.query_one(".robot").render()).splitlines()  # type: ignore[attr-defined]

    def words(self, name: str) -> str:
        words = self.agent.query_one(f".{name}")
        return str(words.render()) if words.display else ""  # type: ignore[attr-defined]

    def watch(self, duration: int) -> list[list[str]]:
        """The drawings that follow each other while time passes."""
        seen, until = [self.drawing], self.clock.now() + duration
        while self.clock.step(until):
            if self.drawing != seen[-1]:
                seen.append(self.drawing)
        self.clock.set(until)
        return seen

    def draws_again(self) -> bool:
        """Return True if a timer is set."""
        return self.clock.step()


@asynccontextmanager
async def enter(theme: Theme) -> AsyncIterator[Room]:
    room = Room(theme)

    class Hall(App[None]):
        def compose(self) -> ComposeResult:
            yield room.agent

    async with Hall().run_test(size=(80, 24)) as room.pilot:
        yield room


async def test_initially_it_is_at_rest_and_silent_without_timers(calm: Theme) -> None:
    async with enter(calm) as room:
        assert calm.faces["neutral"].splitlines()[1] in room.drawing[2]
        assert (room.words("said"), room.words("more"), room.words("note")) == ("", "", "")
        assert not room.draws_again()


async def test_text_stays_until_replaced_and_without_text_only_the_face_changes(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.say("Well done.", "happy", "positive")
        room.agent.say("", "speaking")
        assert room.words("said") == "Well done."
        assert room.agent.has_class("positive")
        assert calm.faces["speaking"].splitlines()[2] in room.drawing[3]
        room.agent.say("Go on.", "")
        assert room.words("said") == "Go on."
        assert not room.agent.has_class("positive")
        assert calm.faces["speaking"].splitlines()[2] in room.drawing[3]


async def test_joined_text_is_below_the_earlier_text_and_disappears_with_it(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.say("Well done.", "happy", "positive")
        room.agent.say("Now have a rest.", "sleeping", joins=True)
        assert (room.words("said"), room.words("more")) == ("Well done.", "Now have a rest.")
        assert room.agent.has_class("positive")
        await room.pilot.pause()
        said, more = room.agent.query_one(".said"), room.agent.query_one(".more")
        assert more.region.y > said.region.bottom - 1
        room.agent.say("Again.", "happy")
        assert (room.words("said"), room.words("more")) == ("Again.", "")


async def test_joined_text_without_earlier_text_is_shown_alone(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.say("Now have a rest.", "sleeping", joins=True)
        assert (room.words("said"), room.words("more")) == ("Now have a rest.", "")


async def test_clearing_removes_the_text_and_resets_the_gaze(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.gaze("left")
        room.agent.say("Well done.", "happy", "positive")
        room.agent.clear("listening")
        assert room.words("said") == ""
        assert calm.faces["listening"].splitlines()[1] in room.drawing[2]


async def test_an_unknown_expression_is_the_neutral_one(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.say("Well done.", "delighted")
        assert calm.faces["neutral"].splitlines()[1] in room.drawing[2]


async def test_a_gesture_starts_and_ends_at_rest_and_then_nothing_is_drawn(calm: Theme) -> None:
    async with enter(calm) as room:
        rest = room.drawing
        room.agent.gesture(ARMS_UP)
        seen = room.watch(1100 * MS)
        assert any(drawing[0].count("●") == 2 for drawing in seen)
        assert len(seen) >= 6  # hanging, out, slanted, up, and down again
        assert seen[-1] == rest
        assert not room.draws_again()


async def test_a_gesture_is_drawn_at_about_fifteen_frames_a_second(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.gesture(ARMS_UP)
        frames = 0
        while room.clock.step():
            frames += 1
        assert frames == pytest.approx(ARMS_UP.duration_ms * MS / FRAME, abs=1)


async def test_a_gesture_replaces_another_without_a_jump(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.gesture(ARMS_UP)
        before = room.watch(400 * MS)[-1]
        room.agent.gesture(ARMS_UP)
        assert room.drawing == before
        room.watch(1100 * MS)
        assert not room.draws_again()


async def test_a_stop_puts_it_at_rest_at_once(calm: Theme) -> None:
    async with enter(calm) as room:
        rest = room.drawing
        room.agent.gesture(ARMS_UP)
        room.agent.gaze("left")
        room.watch(300 * MS)
        assert room.drawing != rest
        room.agent.be_still()
        assert room.drawing == rest
        assert not room.draws_again()


@pytest.mark.parametrize("name", ["calm", "high-contrast", "playful"])
@pytest.mark.parametrize("face", ["neutral", "happy", "speaking"])
async def test_the_mouth_opens_and_shuts_while_a_voice_sounds(name: str, face: str, catalogue: Catalogue) -> None:
    theme = catalogue.theme(name)
    async with enter(theme) as room:
        room.agent.say("Well done.", face)
        silent = room.drawing
        room.agent.speaking(True)
        seen = room.watch(SECOND)
        assert len(seen) == pytest.approx(SECOND / MOUTH, abs=1)
        mouths = {drawing[1 + theme.mouth_line] for drawing in seen}
        assert len(mouths) == 2
        assert {tuple(line for row, line in enumerate(drawing) if row != 1 + theme.mouth_line) for drawing in seen} == {
            tuple(line for row, line in enumerate(silent) if row != 1 + theme.mouth_line)
        }
        room.agent.speaking(False)
        assert room.drawing == silent
        assert not room.draws_again()


async def test_repeated_reports_of_a_voice_do_not_change_the_pace_of_the_mouth(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.speaking(True)
        frames = 0
        while room.clock.now() < SECOND and room.clock.step():
            room.agent.speaking(True)
            frames += 1
        assert frames == pytest.approx(SECOND / FRAME, abs=1)


async def test_while_held_it_draws_nothing_whatever_it_is_asked(calm: Theme) -> None:
    async with enter(calm) as room:
        rest = room.drawing
        room.agent.gesture(ARMS_UP)
        room.agent.speaking(True)
        room.watch(300 * MS)
        room.agent.hold()
        assert room.drawing == rest
        room.agent.gesture(ARMS_UP)
        room.agent.gaze("left")
        room.agent.speaking(True)
        assert room.watch(2 * SECOND) == [rest]
        assert not room.draws_again()


async def test_after_a_hold_the_mouth_continues_with_the_voice(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.speaking(True)
        room.agent.hold()
        room.agent.release()
        assert len(room.watch(SECOND)) > 4


async def test_another_theme_redraws_the_current_face_at_once(calm: Theme, catalogue: Catalogue) -> None:
    plain = catalogue.theme("high-contrast")
    async with enter(calm) as room:
        room.agent.say("Well done.", "happy", "positive")
        room.agent.apply_theme(plain)
        assert all(
            line in drawn for line, drawn in zip(plain.faces["happy"].splitlines(), room.drawing[1:], strict=False)
        )
        assert room.words("said") == "Well done."


async def test_a_note_is_below_the_text_and_disappears_when_empty(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.say("Well done.", "happy")
        room.agent.note("Please read.")
        assert room.words("note") == "Please read."
        room.agent.note("")
        assert room.words("note") == ""


async def test_no_timer_is_left_when_the_agent_is_removed(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.speaking(True)
    assert not room.draws_again()


# --- a cue before a prompt ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gaze", "gesture"), [("left", None), ("right", None), ("", ARMS_UP), ("left", ARMS_UP)])
async def test_a_cue_is_one_frame_while_held_and_disappears_afterwards(
    calm: Theme, gaze: str, gesture: Gesture | None
) -> None:
    async with enter(calm) as room:
        rest = room.drawing
        room.agent.hold()
        room.agent.cue(gaze, gesture)
        cued = room.drawing
        assert cued != rest
        assert room.watch(2 * SECOND) == [cued]
        assert not room.draws_again()
        room.agent.release()
        assert room.drawing == rest


async def test_a_cue_to_one_side_is_the_mirror_of_one_to_the_other(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.hold()
        drawn = []
        for side in ("left", "right"):
            room.agent.cue(side)
            eyes = next(line for line in room.drawing if "●" in line)
            drawn.append([column for column, character in enumerate(eyes) if character == "●"])
        left, right = drawn
        assert [column + 2 for column in left] == right


async def test_joined_text_is_below_all_earlier_text(calm: Theme) -> None:
    async with enter(calm) as room:
        room.agent.say("One.")
        room.agent.say("Two.", joins=True)
        room.agent.say("Three.", joins=True)
        assert (room.words("said"), room.words("more")) == ("One.", "Two.\nThree.")
        room.agent.say("Four.")
        room.agent.say("Five.", joins=True)
        assert (room.words("said"), room.words("more")) == ("Four.", "Five.")
