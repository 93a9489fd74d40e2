"""The condition of an attempt: asked for when it begins, kept with it, the same again in a resumed
session.
"""

import pytest

from sar_tui.loop.topics import ATTEMPT_ENDED, ATTEMPT_STARTED, FEEDBACK, PROMPT
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Situation, Stimulus
from tests.facts import each
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast


class Blocked(Contrast):
    """Each second attempt is cued; the prompt names the condition, and those of the attempts
    before.
    """

    def condition(self, situation: Situation) -> str:
        assert situation.trial == 1
        return "cued" if situation.attempt % 2 == 0 else ""

    def stimulus(self, situation: Situation) -> Stimulus:
        before = "-".join(past.condition for past in situation.history)
        return Stimulus(name="c1", expected="f", text=f"Now:{situation.condition}:{before}")


def test_it_is_kept_with_the_attempt_and_known_to_its_prompts(calm: Theme) -> None:
    driver = LoopDriver(Blocked, calm, attempts=3)
    driver.enter()
    for _ in range(3):
        driver.attempt()
    assert [started.condition for started in driver.all(ATTEMPT_STARTED)] == ["", "cued", ""]
    assert [ended.condition for ended in driver.all(ATTEMPT_ENDED)] == ["", "cued", ""]
    assert [feedback.condition for feedback in driver.all(FEEDBACK)] == ["", "cued", ""]
    assert each(driver.all(PROMPT), "text")[::6] == ["Now::", "Now:cued:", "Now::-cued"]


def test_it_is_the_same_in_a_resumed_session(calm: Theme) -> None:
    whole = LoopDriver(Blocked, calm, attempts=3)
    whole.enter()
    whole.attempt()
    whole.begin_attempt()
    whole.answer()
    driver = LoopDriver(Blocked, calm, attempts=3, history=whole.records)
    driver.press("enter")
    assert driver.to_prompt().text == "Now:cued:"


def test_an_attempt_that_is_scored_again_keeps_it(calm: Theme) -> None:
    driver = LoopDriver(Blocked, calm, attempts=3)
    driver.enter()
    driver.attempt()
    driver.attempt()
    driver.operate("mark", "slip")
    assert [ended.condition for ended in driver.all(ATTEMPT_ENDED)] == ["", "cued", "cued"]


@pytest.mark.parametrize("returned", [None, 3, "two\nlines"])
def test_what_cannot_be_stored_ends_the_session_with_a_sentence(
    calm: Theme, returned: object
) -> None:
    class Wrong(Contrast):
        def condition(self, situation: Situation) -> str:
            return returned  # type: ignore[return-value]

    driver = LoopDriver(Wrong, calm, attempts=1)
    driver.enter()
    driver.press("enter")
    assert driver.session.broken
    assert "not a line of plain text" in driver.session.broken.error
