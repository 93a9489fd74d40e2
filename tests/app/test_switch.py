"""Whole sessions with one switch, with two, or with a foot switch that sends Enter only."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.app.screens.settings import FieldPanel
from sar_tui.app.screens.switch_choices import answers
from sar_tui.model.language import Language
from sar_tui.model.messages import Prompt
from sar_tui.model.step import Entry, Given, Step, press
from sar_tui.plugins import Catalogue
from sar_tui.rules.scanning import FIRST_MS, interval_ms
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store.passphrase import Passphrase
from tests.app.app_driver import AppDriver, known, open_app, stored
from tests.store.by_hand import sql

_PATIENCE_MS = 60_000
_STEP_MS = 100


class OneSwitch:
    """A person who sees the mark and can press one key only.

    Args:
        driver: shows the app.
        key: that the switch sends.
        bounce_ms: after this time each press is doubled; 0: it is not.
    """

    def __init__(self, driver: AppDriver, key: str = "space", bounce_ms: int = 0) -> None:
        self.driver = driver
        self.key = key
        self._bounce_ms = bounce_ms

    async def press(self) -> None:
        await self.driver.strike(self.key)
        if self._bounce_ms:
            await self.driver.wait(self._bounce_ms)
            await self.driver.strike(self.key)

    async def choose(self, *labels: str) -> None:
        """Choose one after the other, each a moment after it is marked."""
        for label in labels:
            await self.wait_for(label)
            await self.press()

    async def wait_for(self, label: str) -> None:
        """Read what appears, and wait until a choice has been marked for a moment."""
        await self.driver.wait(800)
        since = 0
        for _ in range(_PATIENCE_MS // _STEP_MS):
            switch = self.driver.app.switch
            since = since + 1 if switch and switch.marked == label else 0
            if since > 3:
                return
            await self.driver.wait(_STEP_MS)
        raise AssertionError(f"{label} is never marked:\n{self.driver.text}")

    async def go_on(self, stage: str) -> None:
        """Wait until the session is at a stage, and go on there."""
        for _ in range(_PATIENCE_MS // _STEP_MS):
            if self.driver.waiting.stage == stage:
                await self.choose("Go on")
                return
            await self.driver.wait(_STEP_MS)
        raise AssertionError(f"the session waits for {self.driver.waiting}")


class TwoSwitches(OneSwitch):
    """A person with two switches: Space moves the mark, Enter takes."""

    async def wait_for(self, label: str) -> None:
        await self.driver.wait(800)
        for _ in range(20):
            switch = self.driver.app.switch
            if switch and switch.marked == label:
                return
            await self.driver.strike("space")
            await self.driver.wait(800)
        raise AssertionError(f"{label} is never marked:\n{self.driver.text}")

    async def press(self) -> None:
        await self.driver.strike("enter")


def planned(catalogue: Catalogue, task: str, **settings: Any) -> Plan:
    values = {"attempts": 2, "switch": "one", "ask_wellbeing": True, **settings}
    return make_plan(catalogue, task, ["P01"], values, theme="calm", seed=7)


async def respond(person: OneSwitch, prompt: Prompt) -> None:
    """Respond to a prompt of one of the three tasks, and nothing else."""
    driver = person.driver
    if prompt.stimulus == "tap":
        for _ in range(9):
            await driver.wait(150)
            await person.press()
        await driver.wait(3000)
    elif prompt.stimulus == "go":
        await driver.wait(400)
        await person.press()
    elif prompt.stimulus == "no go":
        await driver.wait(1300)
    else:
        await driver.wait(2500)
        await person.press()


async def do_attempt(person: OneSwitch, task: str) -> None:
    """Do the attempt that waits to be begun."""
    driver = person.driver
    await person.go_on("attempt")
    for _ in range(driver.session.task.trials_per_attempt):
        if task == "reaching":
            await driver.wait(3000)
            await person.choose("Start")
            prompt = driver._prompts[-1]
        else:
            prompt = await driver.to_prompt()
        await respond(person, prompt)
    await driver.wait(2000)


async def tell_wellbeing(person: OneSwitch) -> None:
    await person.choose("2", "Yes", "3 left arm", "Yes", "0 not tired", "Yes")


async def do_session(person: OneSwitch, task: str) -> None:
    """Do a whole session: questions, two attempts with a pause between them, and the summary."""
    driver = person.driver
    await tell_wellbeing(person)
    if task == "reaching":
        await person.choose("Begin")
        await driver.wait(100)
    await person.go_on("instructions")
    await do_attempt(person, task)
    await person.choose("Pause", "I am tired", "Go on")
    await do_attempt(person, task)
    await person.go_on("review")
    await person.choose("Finish")
    await tell_wellbeing(person)
    await driver.wait(500)


SETTINGS: dict[str, dict[str, Any]] = {
    "gonogo": {"prompts_per_attempt": 8},
    "tapping": {"seconds": 2.0},
    "reaching": {"imu": "simulated"},
}


def assert_whole(driver: AppDriver, task: str) -> None:
    """Assert that a session was done and stored as by any other key."""
    ((status,),) = driver.stored("SELECT status FROM sessions")
    assert status == "completed"
    trials = driver.stored("SELECT correct FROM trials")
    assert [correct for (correct,) in trials] == [1] * len(trials)
    told = driver.stored("SELECT kind, count(DISTINCT id) FROM records GROUP BY kind")
    assert told == [("pain", 2), ("tiredness", 3)]
    if task == "tapping":
        taps = driver.stored("SELECT json_extract(details, '$.taps') FROM trials")
        assert taps == [(9,), (9,)]


@pytest.mark.slow
@pytest.mark.parametrize("task", SETTINGS)
async def test_a_session_with_space_alone(data: Path, catalogue: Catalogue, task: str) -> None:
    async with open_app(data, catalogue, planned(catalogue, task, **SETTINGS[task])) as driver:
        await do_session(OneSwitch(driver), task)
        assert_whole(driver, task)


@pytest.mark.slow
@pytest.mark.parametrize("task", SETTINGS)
async def test_presses_that_bounce_begin_nothing_twice(
    data: Path, catalogue: Catalogue, task: str
) -> None:
    plan = planned(catalogue, task, bounce_ms=100, **SETTINGS[task])
    async with open_app(data, catalogue, plan) as driver:
        await do_session(OneSwitch(driver, bounce_ms=40), task)
        assert_whole(driver, task)
        outcomes = [each["outcome"] for each in driver.messages("input/switch")]
        assert set(outcomes) == {"taken", "held"}


@pytest.mark.slow
@pytest.mark.parametrize("task", SETTINGS)
async def test_a_session_with_two_switches(data: Path, catalogue: Catalogue, task: str) -> None:
    plan = planned(catalogue, task, switch="two", **SETTINGS[task])
    async with open_app(data, catalogue, plan) as driver:
        await do_session(TwoSwitches(driver), task)
        assert_whole(driver, task)


async def test_patient_mode_with_a_foot_switch_that_sends_enter(
    data: Path, catalogue: Catalogue
) -> None:
    Passphrase(data).set("quiet river")
    values = {"attempts": 2, "switch": "one", "ask_wellbeing": True, "prompts_per_attempt": 8}
    known(data, task="gonogo", **values)
    async with open_app(data, catalogue, patient="P01") as driver:
        foot = OneSwitch(driver, "enter")
        await foot.choose("Start")
        await do_session(foot, "gonogo")
        assert_whole(driver, "gonogo")
        await foot.choose("Start again", "No")


async def test_a_press_on_each_screen_in_turn_is_seen_in_the_row_of_the_key(
    data: Path, catalogue: Catalogue
) -> None:
    async with open_app(
        data, catalogue, planned(catalogue, "gonogo", ask_wellbeing=False)
    ) as driver:
        driver.see("Press to choose: ▸ Go on Pause")
        await OneSwitch(driver).choose("Pause")
        driver.see("Paused", "Press when your choice is marked.")


async def test_a_pause_with_one_switch_offers_nothing_of_the_therapist(
    data: Path, catalogue: Catalogue
) -> None:
    async with open_app(
        data, catalogue, planned(catalogue, "gonogo", ask_wellbeing=False)
    ) as driver:
        await OneSwitch(driver).choose("Pause")
        await driver.wait(800)
        seen = set()
        for _ in range(200):
            seen.add(driver.app.switch.marked)
            await driver.wait(100)
        assert seen == {"Go on", "I am tired", "I am in pain", "I am finished"}


async def pressed(data: Path, catalogue: Catalogue, times: int, who: str = "P01") -> list[Any]:
    """Go to and from a pause in a session, and return what was recorded of each press."""
    values = {"attempts": 2, "switch": "one"}
    plan = make_plan(catalogue, "gonogo", [who], values, theme="calm", seed=7)
    async with open_app(data, catalogue, plan) as driver:
        for _ in range(times):
            await OneSwitch(driver).choose("Pause", "Go on")
        await driver.wait(100)
    of_this = "session=(SELECT id FROM sessions ORDER BY rowid DESC LIMIT 1) ORDER BY seq"
    query = f"SELECT message FROM events WHERE topic='input/switch' AND {of_this}"
    return [msgspec.json.decode(text) for (text,) in stored(data, query)]


@pytest.mark.slow
async def test_the_scan_interval_goes_on_from_a_persons_earlier_sessions(
    data: Path, catalogue: Catalogue
) -> None:
    first = await pressed(data, catalogue, 4)
    times = [press["press_ms"] for press in first if press["press_ms"]]
    (begun, *_) = await pressed(data, catalogue, 1)
    assert begun["interval_ms"] == interval_ms(times) < FIRST_MS


async def test_the_scan_interval_of_one_person_is_not_that_of_another(
    data: Path, catalogue: Catalogue
) -> None:
    await pressed(data, catalogue, 4)
    (begun, *_) = await pressed(data, catalogue, 1, who="P02")
    assert begun["interval_ms"] == FIRST_MS


async def test_a_press_that_cannot_be_read_keeps_no_session_from_beginning(
    data: Path, catalogue: Catalogue
) -> None:
    await pressed(data, catalogue, 4)
    of_switch = "topic=(SELECT id FROM topics WHERE name='input/switch')"
    assert sql(data, f"UPDATE messages SET message='[' WHERE {of_switch} RETURNING seq")
    (begun, *_) = await pressed(data, catalogue, 1)
    assert begun["interval_ms"] == FIRST_MS


@pytest.mark.slow
async def test_the_settings_tell_the_scan_interval_that_follows_the_person(
    data: Path, catalogue: Catalogue
) -> None:
    presses = await pressed(data, catalogue, 4)
    times = [press["press_ms"] for press in presses if press["press_ms"]]
    known(data, task="gonogo", switch="one")
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        fields = {
            each.field.name: each
            for panel in driver.app.screen.query(FieldPanel)
            for each in panel.fields
        }
        assert fields["scan_interval_ms"].note.endswith(
            f"It is {interval_ms(times) / 1000:g} s now."
        )


async def test_a_press_right_after_the_mark_has_moved_takes_what_was_marked_before(
    data: Path, catalogue: Catalogue
) -> None:
    plan = planned(catalogue, "gonogo", ask_wellbeing=False)
    async with open_app(data, catalogue, plan) as driver:
        person = OneSwitch(driver)
        await person.choose("Pause")
        await person.wait_for("I am tired")
        while driver.app.switch.marked == "I am tired":
            await driver.wait(20)
        await person.press()
        driver.see("Have a rest")


async def test_the_mark_rests_while_a_response_is_awaited(data: Path, catalogue: Catalogue) -> None:
    plan = planned(catalogue, "gonogo", ask_wellbeing=False, squares=0.1)
    async with open_app(data, catalogue, plan) as driver:
        person = OneSwitch(driver)
        await person.go_on("instructions")
        await person.go_on("attempt")
        await driver.to_prompt()
        assert driver.app.switch.marked == ""
        driver.lacks("▸")


async def test_a_session_pauses_when_nobody_presses_any_more(
    data: Path, catalogue: Catalogue
) -> None:
    plan = planned(catalogue, "gonogo", ask_wellbeing=False, squares=0.1)
    async with open_app(data, catalogue, plan) as driver:
        person = OneSwitch(driver)
        await person.go_on("instructions")
        await person.go_on("attempt")
        await driver.wait(30_000)
        assert driver.waiting.stage == "paused"
        await person.choose("Go on")
        await driver.wait(1000)
        assert driver.waiting.stage == "trial"


async def test_to_train_in_spite_of_pain_takes_a_second_choice(
    data: Path, catalogue: Catalogue
) -> None:
    async with open_app(data, catalogue, planned(catalogue, "gonogo")) as driver:
        person = OneSwitch(driver)
        await person.choose("9", "Yes", "3 left arm", "Yes", "0 not tired", "Yes")
        driver.see("Please do not train now")
        await person.choose("Train all the same", "No", "Train all the same", "Yes")
        await person.go_on("instructions")


async def test_an_answer_is_chosen_again_after_no(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue, planned(catalogue, "gonogo")) as driver:
        await OneSwitch(driver).choose("9", "No", "1", "Yes")
        driver.see("Where does it hurt?", "You said: 1.")


async def test_questions_between_attempts_are_answered_with_a_switch(
    data: Path, catalogue: Catalogue
) -> None:
    plan = planned(
        catalogue,
        "gonogo",
        attempts=1,
        ask_wellbeing=False,
        prompts_per_attempt=4,
        questions="exertion",
    )
    async with open_app(data, catalogue, plan) as driver:
        person = OneSwitch(driver)
        await person.go_on("instructions")
        await do_attempt(person, "gonogo")
        await person.choose(driver.app.switch.marked, "Yes")
        assert driver.messages("event_handler/step_ended")[0]["status"] == "answered"


async def test_a_switch_that_is_held_down_takes_one_choice(
    data: Path, catalogue: Catalogue
) -> None:
    async with open_app(data, catalogue, planned(catalogue, "gonogo")) as driver:
        person = OneSwitch(driver)
        await person.wait_for("4")
        for _ in range(100):
            await driver.strike("space")
            await driver.wait(33)
        driver.see("How much pain do you have now?", "You chose: 4.")


async def test_a_tiny_window_and_the_help_leave_the_choices_as_they_were(
    data: Path, catalogue: Catalogue
) -> None:
    async with open_app(data, catalogue, planned(catalogue, "gonogo")) as driver:
        person = OneSwitch(driver)
        await driver.resize(20, 5)
        await driver.wait(3000)
        await person.press()
        await driver.resize(80, 24)
        await driver.press("f1")
        assert driver.screen_name == "HelpScreen"
        await driver.wait(3000)
        await driver.press("escape")
        await person.choose("7", "No")
        driver.see("How much pain do you have now?")
        assert driver.stored("SELECT 1 FROM records") == []


async def test_an_interrupted_session_goes_on_with_the_switch(
    data: Path, catalogue: Catalogue
) -> None:
    plan = planned(catalogue, "gonogo", ask_wellbeing=False, prompts_per_attempt=4)
    async with open_app(data, catalogue, plan) as driver:
        await OneSwitch(driver).go_on("instructions")
        await do_attempt(OneSwitch(driver), "gonogo")
        session = driver.session_id
    async with open_app(data, catalogue, session) as driver:
        driver.see("Welcome back")
        await OneSwitch(driver).choose("Go on")
        await do_attempt(OneSwitch(driver), "gonogo")
        assert driver.waiting.stage == "review"


async def test_the_therapist_has_the_keys_after_the_session(
    data: Path, catalogue: Catalogue
) -> None:
    known(data, task="gonogo", switch="one")
    async with open_app(data, catalogue) as driver:
        assert driver.app.switch is None


STEPS = (
    (Step(name="n", text="?", kind="number"), Entry(), "10", ("1", "0", "enter")),
    (
        Step(name="n", text="?", kind="number"),
        Entry(chosen=(1,), typed="1"),
        "0",
        ("right", "0", "enter"),
    ),
    (Step(name="l", text="?", kind="likert", labels=("a", "b")), Entry(), "2 b", ("2", "enter")),
    (
        Step(name="b", text="?", kind="borg"),
        Entry(),
        "0.5 extremely weak",
        ("0", ".", "5", "enter"),
    ),
    (Step(name="v", text="?", kind="line"), Entry(), "100", ("end", "enter")),
    (Step(name="v", text="?", kind="line"), Entry(), "30", ("3", "enter")),
    (Step(name="c", text="?", kind="choices", labels=("a", "b")), Entry(), "2 b", ("2",)),
    (
        Step(name="c", text="?", kind="choices", labels=("a", "b")),
        Entry(chosen=(1,)),
        "Done",
        ("enter",),
    ),
    (Step(name="t", text="?", kind="text"), Entry(), "I would rather not say", ("tab",)),
)


@pytest.mark.parametrize(("step", "entry", "label", "keys"), STEPS)
def test_the_keys_of_an_answer_give_it(
    step: Step, entry: Entry, label: str, keys: tuple[str, ...]
) -> None:
    (choice,) = [each for each in answers(step, entry, Language()) if each.label == label]
    assert choice.keys == keys
    given: Entry | Given = entry
    for key in keys:
        assert isinstance(given, Entry)
        given = press(step, given, key)
    if step.kind not in ("choices", "text"):
        assert isinstance(given, Given)
        assert str(given.answer).startswith(label.split(maxsplit=1)[0])


def test_nothing_is_offered_once_somebody_types_words() -> None:
    assert answers(Step(name="t", text="?", kind="text"), Entry(typed="a"), Language()) == ()
