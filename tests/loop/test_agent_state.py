"""The agent's words, face, cue and mouth follow a session's messages."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.agent_state import AgentState, step
from sar_tui.model.messages import (
    Action,
    AgentActing,
    CueGiven,
    Halt,
    Message,
    OutputReport,
    Waiting,
)
from tests.facts import facts

FOREPERIOD = Waiting(what="foreperiod", stage="trial")
HALT = Halt(reason="stopped", asked=0)
BETWEEN = Waiting(what="enter", stage="attempt")


def action(text: str = "", **more: Any) -> Action:
    return Action(
        **({"id": "a1", "kind": "feedback"} | more), text=text, decision="accepted", actor="agent"
    )


def report(state: Any, output: str = "speech", part: Any = "say") -> OutputReport:
    return OutputReport(action="a1", output=output, part=part, state=state, at=0)


SILENT = AgentState()


def after(*messages: Message, state: AgentState = SILENT) -> AgentState:
    for message in messages:
        state = step(state, message)
    return state


def test_words_replace_others_and_joined_words_stand_below_them() -> None:
    state = after(
        action("Well done.", face="happy", valence="positive"), action("Rest.", joins=True)
    )
    assert facts(state, "words more face valence") == ("Well done.", "Rest.", "happy", "positive")
    state = after(action("Again."), state=state)
    assert (state.words, state.more, state.face) == ("Again.", "", "happy")


def test_a_gesture_alone_leaves_the_words() -> None:
    state = after(action("Well done."), action(gesture="wave"))
    assert state.words == "Well done."
    assert state.moves
    assert state.moves.gesture == "wave"


def test_before_a_trial_the_words_go_and_the_agent_listens() -> None:
    state = after(action("Well done.", face="happy"), FOREPERIOD)
    assert (state.words, state.face) == ("", "listening")
    assert after(action("Well done."), Waiting(what="agent", stage="trial")).words == "Well done."


def test_a_filler_disappears_when_its_wait_is_over() -> None:
    assert after(action("Just a moment.", kind="filler"), BETWEEN).words == ""
    assert after(action("Well done."), BETWEEN).words == "Well done."


def test_it_thinks_while_an_answer_is_awaited_and_not_longer() -> None:
    state = after(Waiting(what="answer", stage="answer"))
    assert state.face == "thinking"
    assert after(BETWEEN, state=state).face == "listening"


def test_a_cue_is_shown_until_the_response() -> None:
    cue = CueGiven(attempt=1, trial=1, presentation=1, side="left", gaze="left")
    assert after(cue, FOREPERIOD, Waiting(what="response", stage="trial")).cue == cue
    assert after(cue, Waiting(what="quiet", stage="trial")).cue is None


def test_it_speaks_while_any_voice_sounds() -> None:
    state = after(report("queued"))
    assert not state.is_speaking
    state = after(report("started"), report("started", "ros"), state=state)
    assert after(report("done"), state=state).is_speaking
    assert not after(report("done"), report("failed", "ros"), state=state).is_speaking
    assert not after(report("started", part="gesture")).is_speaking


@given(
    st.lists(
        st.sampled_from(
            [report("started"), report("started", "ros"), report("done"), HALT, FOREPERIOD]
        )
    )
)
def test_once_the_agent_has_stopped_acting_its_mouth_is_shut(messages: list[Message]) -> None:
    assert not after(*messages, AgentActing(acting=False)).is_speaking
    assert not after(*messages).silenced().is_speaking


def test_the_face_is_kind_in_a_pause_and_rests_with_somebody_tired() -> None:
    def paused(reason: str) -> Waiting:
        return Waiting(what="resume", stage="paused", reason=reason)

    praised = after(action("Well done.", face="happy"))
    state = after(paused(""), state=praised)
    assert (state.face, state.words) == ("encouraging", "Well done.")
    assert after(BETWEEN, state=state).face == "happy"
    state = after(paused("tired"), state=state)
    assert (state.face, state.words) == ("sleeping", "")
    assert after(BETWEEN, state=state).face == "happy"
    assert after(FOREPERIOD, state=state).face == "listening"
    assert after(paused("pain"), state=state).face == "encouraging"
