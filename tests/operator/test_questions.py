"""An operator sees the question that a participant is asked, and not what they choose or type."""

from msgspec.structs import replace

from sar_tui.model.messages import AskedStep
from sar_tui.model.step import Entry, Step
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.status_view import waiting_text
from tests.operator.panel_driver import waiting

EMPTY = Entry()


def told(step: Step, entry: Entry = EMPTY) -> str:
    asked = AskedStep(number=1, step=step, entry=entry)
    return waiting_text(replace(SessionState(), waiting=waiting("step", "step", step=asked)))


def test_the_question_stands_on_the_panel_without_its_answer() -> None:
    question = Step(name="word", text="Anything else?", kind="text")
    assert told(question, Entry(typed="my secret")) == "Waits for an answer: Anything else?"


def test_what_is_read_or_waited_for_stands_there_too() -> None:
    assert told(Step(name="read", text="Now the other hand.")) == "Now the other hand."
    assert (
        told(Step(name="still", kind="calibration", text="Keep still.", seconds=3)) == "Keep still."
    )
