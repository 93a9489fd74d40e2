"""The agent on the screen: what moves, when, and when nothing does."""

from collections.abc import AsyncIterator

import pytest
from textual.app import App, ComposeResult
from textual.pilot import Pilot

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.gesture import Gesture, Keyframe
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.plugins import Catalogue
from sar_tui.widgets.agent import FRAME, MOUTH, Agent

ARMS_UP = Gesture((Keyframe(at_ms=400, left_arm=1, right_arm=1), Keyframe(at_ms=1000)))


class Stage:
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


@pytest.fixture
async def stage(calm: Theme) -> AsyncIterator[Stage]:
    stage = Stage(calm)

    class StageApp(App[None]):
        def compose(self) -> ComposeResult:
            yield stage.agent

    async with StageApp().run_test(size=(80, 24)) as stage.pilot:
        yield stage
        stage.agent.speaking(True)
    assert not stage.draws_again(), "no timer is left when it is removed"


async def test_initially_it_is_at_rest_and_silent_without_timers(stage: Stage, calm: Theme) -> None:
    assert calm.faces["neutral"].splitlines()[1] in stage.drawing[2]
    assert (stage.words("said"), stage.words("more"), stage.words("note")) == ("", "", "")
    assert not stage.draws_again()


async def test_text_stays_until_replaced(stage: Stage, calm: Theme) -> None:
    stage.agent.say("Well done.", "happy", "positive")
    stage.agent.say("", "thinking")
    assert stage.words("said") == "Well done."
    assert stage.agent.has_class("positive")
    assert calm.faces["thinking"].splitlines()[2] in stage.drawing[3]
    stage.agent.say("Go on.", "")
    assert stage.words("said") == "Go on."
    assert not stage.agent.has_class("positive")
    assert calm.faces["thinking"].splitlines()[2] in stage.drawing[3]


async def test_clearing_removes_the_text_but_not_the_note_and_resets_the_gaze(
    stage: Stage, calm: Theme
) -> None:
    stage.agent.gaze("left")
    stage.agent.say("Well done.", "happy", "positive")
    stage.agent.note("Please read.")
    stage.agent.clear("listening")
    assert (stage.words("said"), stage.words("note")) == ("", "Please read.")
    assert calm.faces["listening"].splitlines()[1] in stage.drawing[2]
    stage.agent.note("")
    assert stage.words("note") == ""
    stage.agent.say("Well done.", "delighted")
    assert calm.faces["neutral"].splitlines()[1] in stage.drawing[2], "that face is unknown"


async def test_a_gesture_starts_and_ends_at_rest_and_then_nothing_is_drawn(stage: Stage) -> None:
    rest = stage.drawing
    stage.agent.gesture(ARMS_UP)
    seen = stage.watch(1100 * MS)
    assert any(drawing[0].count("●") == 2 for drawing in seen)
    assert len(seen) >= 6  # hanging, out, slanted, up, and down again
    assert seen[-1] == rest
    assert not stage.draws_again()
    stage.agent.gesture(ARMS_UP)
    frames = 0
    while stage.clock.step():
        frames += 1
    assert frames == pytest.approx(ARMS_UP.duration_ms * MS / FRAME, abs=1)


async def test_a_gesture_replaces_another_without_a_jump(stage: Stage) -> None:
    stage.agent.gesture(ARMS_UP)
    before = stage.watch(400 * MS)[-1]
    stage.agent.gesture(ARMS_UP)
    assert stage.drawing == before
    stage.watch(1100 * MS)
    assert not stage.draws_again()


async def test_a_stop_puts_it_at_rest_at_once(stage: Stage) -> None:
    rest = stage.drawing
    stage.agent.gesture(ARMS_UP)
    stage.agent.gaze("left")
    stage.watch(300 * MS)
    assert stage.drawing != rest
    stage.agent.be_still()
    assert stage.drawing == rest
    assert not stage.draws_again()


@pytest.mark.parametrize("face", ["happy", "speaking"])
async def test_only_the_mouth_moves_while_a_voice_sounds(
    stage: Stage, calm: Theme, face: str
) -> None:
    stage.agent.say("Well done.", face)
    silent = stage.drawing
    stage.agent.speaking(True)
    seen = stage.watch(SECOND)
    assert len(seen) == pytest.approx(SECOND / MOUTH, abs=1)
    at = 1 + calm.mouth_line
    assert len({drawing[at] for drawing in seen}) == 2
    around = {tuple(drawing[:at] + drawing[at + 1 :]) for drawing in (silent, *seen)}
    assert len(around) == 1
    stage.agent.speaking(False)
    assert stage.drawing == silent
    assert not stage.draws_again()


async def test_the_speaking_face_shuts_its_mouth(stage: Stage, calm: Theme) -> None:
    shut, opened = (
        calm.faces[face].splitlines()[calm.mouth_line] for face in ("neutral", "speaking")
    )

    def mouth() -> str:
        return stage.drawing[1 + calm.mouth_line]

    stage.agent.say("Press the key that appears.", "speaking")
    assert shut in mouth()
    stage.agent.speaking(True)
    assert opened in mouth()
    stage.agent.hold()
    assert shut in mouth(), "nothing moves while a response is awaited, and the mouth is shut"
    stage.agent.release()
    assert opened in mouth()
    stage.agent.speaking(False)
    assert shut in mouth()


async def test_repeated_reports_keep_the_pace_of_the_mouth(stage: Stage) -> None:
    stage.agent.speaking(True)
    frames = 0
    while stage.clock.now() < SECOND and stage.clock.step():
        stage.agent.speaking(True)
        frames += 1
    assert frames == pytest.approx(SECOND / FRAME, abs=1)


async def test_nothing_is_drawn_while_drawing_is_held(stage: Stage) -> None:
    rest = stage.drawing
    stage.agent.gesture(ARMS_UP)
    stage.agent.speaking(True)
    stage.watch(300 * MS)
    stage.agent.hold()
    assert stage.drawing == rest
    stage.agent.gesture(ARMS_UP)
    stage.agent.gaze("left")
    stage.agent.speaking(True)
    assert stage.watch(2 * SECOND) == [rest]
    assert not stage.draws_again()


async def test_after_a_hold_the_mouth_continues_with_the_voice(stage: Stage) -> None:
    stage.agent.speaking(True)
    stage.agent.hold()
    stage.agent.release()
    assert len(stage.watch(SECOND)) > 4


async def test_another_theme_redraws_the_face(stage: Stage, catalogue: Catalogue) -> None:
    plain = catalogue.theme("high-contrast")
    stage.agent.say("Well done.", "happy", "positive")
    stage.agent.apply_theme(plain)
    face = plain.faces["happy"].splitlines()
    assert all(map(str.__contains__, stage.drawing[1:], face))
    assert stage.words("said") == "Well done."


# --- a cue before a prompt


@pytest.mark.parametrize(
    ("gaze", "gesture"), [("left", None), ("right", None), ("", ARMS_UP), ("left", ARMS_UP)]
)
async def test_a_cue_is_one_frame_while_held_and_disappears_afterwards(
    stage: Stage, gaze: str, gesture: Gesture | None
) -> None:
    rest = stage.drawing
    stage.agent.hold()
    stage.agent.cue(gaze, gesture)
    cued = stage.drawing
    assert cued != rest
    assert stage.watch(2 * SECOND) == [cued]
    assert not stage.draws_again()
    stage.agent.release()
    assert stage.drawing == rest


async def test_a_cue_to_one_side_is_the_mirror_of_one_to_the_other(stage: Stage) -> None:
    stage.agent.hold()
    drawn = []
    for side in ("left", "right"):
        stage.agent.cue(side)
        eyes = next(line for line in stage.drawing if "●" in line)
        drawn.append([column for column, character in enumerate(eyes) if character == "●"])
    left, right = drawn
    assert [column + 2 for column in left] == right


async def test_joined_text_is_below_all_earlier_text(stage: Stage) -> None:
    stage.agent.say("Now have a rest.", "sleeping", joins=True)
    assert (stage.words("said"), stage.words("more")) == ("Now have a rest.", "")
    stage.agent.say("One.", "happy", "positive")
    stage.agent.say("Two.", "sleeping", joins=True)
    stage.agent.say("Three.", joins=True)
    assert (stage.words("said"), stage.words("more")) == ("One.", "Two.\nThree.")
    assert stage.agent.has_class("positive")
    await stage.pilot.pause()
    said, more = stage.agent.query_one(".said"), stage.agent.query_one(".more")
    assert more.region.y >= said.region.bottom
    stage.agent.say("Four.")
    stage.agent.say("Five.", joins=True)
    assert (stage.words("said"), stage.words("more")) == ("Four.", "Five.")
