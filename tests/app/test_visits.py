"""The participant's screen in a live visit: the question, the sign, the end; with a fake channel."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui.app.visits import may_be_visited
from sar_tui.link.broker_process import OutgoingBatch, OutgoingSnapshot
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import home_file
from sar_tui.link.protocol import Admit, Deny, PeerJoined, PeerLeft, VisitAsked
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.store import passphrase
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.study import ledger
from sar_tui.study.plan import parse_plan
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, known, open_app
from tests.app.test_switch import OneSwitch
from tests.link.test_node import ANNA, FakeChannel
from tests.study.plans import TWO_GROUPS

QUESTION = "Your therapist would like to watch this training"
SIGN = "● Your therapist is watching"


class VisitChannel(FakeChannel):
    """Router and visitor: whoever is admitted joins."""

    def __init__(self) -> None:
        super().__init__(is_visit=True)

    def send(self, message: Any) -> bool:
        if isinstance(message, Admit):
            self.notify(PeerJoined(message.name))
        return super().send(message)

    def of(self, kind: type[Any]) -> list[Any]:
        return [each for each in self.sent if isinstance(each, kind)]


@pytest.fixture
def channel() -> VisitChannel:
    return VisitChannel()


async def asked(driver: AppDriver, channel: VisitChannel) -> None:
    channel.notify(VisitAsked(ANNA))
    await driver.wait(5000)  # the agent is still
    driver.see(QUESTION)


async def test_enter_lets_the_therapist_watch_and_a_sign_says_so_until_they_leave(
    open_session: OpenSession, channel: VisitChannel
) -> None:
    async with open_session(link=channel) as driver:
        await asked(driver, channel)
        driver.see("Enter: yes. Esc: not today.", "You can end this in every pause.")
        assert channel.sent == []
        await driver.press("enter")
        await driver.wait(100)
        driver.see("Press that key as fast as you can", SIGN)
        assert channel.of(Admit) == [Admit(ANNA)]
        prompt = await driver.to_first_prompt()
        driver.see(SIGN)
        channel.notify(PeerLeft(ANNA, "lost", "No heartbeat for 2000 ms."))
        await driver.wait(50)
        driver.see(SIGN)  # nothing is drawn while a response is awaited
        await driver.answer(prompt)
        await driver.answer(await driver.to_prompt())
        await driver.wait(1000)
        driver.lacks(SIGN)
        assert [each["state"] for each in driver.messages("operator/presence")] == [
            "joined", "baton", "lost"
        ]  # fmt: skip
        (asking,), (decided,) = map(driver.messages, ("operator/visit", "event_handler/visit"))
        assert (asking["actor"], asking["state"]) == (ANNA, "asked")
        assert (decided["outcome"], decided["peers"]) == ("agreed", [ANNA])


async def test_escape_lets_nobody_watch_and_the_session_is_as_any_other(
    open_session: OpenSession, channel: VisitChannel
) -> None:
    async with open_session(link=channel) as driver:
        await asked(driver, channel)
        await driver.press("escape")
        await driver.wait(100)
        driver.see("Press that key as fast as you can")
        driver.lacks(SIGN, QUESTION)
        assert channel.of(Deny)
        channel.notify(PeerJoined(ANNA))  # whatever the broker process says
        await driver.do_session()
        assert not channel.of(OutgoingBatch)
        assert not channel.of(OutgoingSnapshot)
        assert driver.messages("operator/presence") == []


async def test_the_participant_ends_a_visit_in_a_pause(
    open_session: OpenSession, channel: VisitChannel
) -> None:
    async with open_session(link=channel) as driver:
        await driver.press("escape")
        driver.lacks("End the visit")
        channel.notify(VisitAsked(ANNA))
        await driver.wait(5000)
        driver.see(QUESTION)
        await driver.press("enter")
        await driver.wait(100)
        driver.see("End the visit", SIGN, "Take your time.")
        await driver.press("down", "down", "down")
        await driver.press("enter")
        await driver.wait(100)
        driver.lacks("End the visit", SIGN)
        driver.see("Take your time.")
        assert channel.of(Deny)
        assert [each["outcome"] for each in driver.messages("event_handler/visit")] == [
            "agreed", "ended"
        ]  # fmt: skip


@pytest.mark.parametrize(("choice", "outcome"), [("Yes", "agreed"), ("Not today", "declined")])
async def test_a_switch_answers_the_question(
    data: Path, catalogue: Catalogue, channel: VisitChannel, choice: str, outcome: str
) -> None:
    plan = make_plan(catalogue, "gonogo", ["P01"], {"switch": "one"}, seed=7)
    async with open_app(data, catalogue, plan, link=channel) as driver:
        await asked(driver, channel)
        await OneSwitch(driver).choose(choice)
        await driver.wait(100)
        assert [each["outcome"] for each in driver.messages("event_handler/visit")] == [outcome]


@pytest.mark.parametrize(
    ("language", "words"),
    [
        (
            "de",
            "Ihre Betreuungsperson möchte bei diesem Training zusehen Enter: ja. Esc: heute nicht.",
        ),
        ("es", "Su terapeuta quisiera ver este entrenamiento Enter: sí. Esc: hoy no."),
    ],
)
async def test_the_question_is_in_the_language_of_the_participant(
    open_session: OpenSession, channel: VisitChannel, language: str, words: str
) -> None:
    async with open_session(link=channel, language=language) as driver:
        channel.notify(VisitAsked(ANNA))
        await driver.wait(5000)
        question, _, keys = words.partition(" Enter: ")
        driver.see(question, f"Enter: {keys}")


# --- which sessions dial out


class Dialled:
    """Counts the links by which sessions dial out."""

    def __init__(self, channel: FakeChannel) -> None:
        self.channel = channel
        self.opened = 0
        self.error = ""

    @contextmanager
    def open(self, *_: object) -> Iterator[FakeChannel]:
        if self.error:
            raise LinkError(self.error)
        self.opened += 1
        yield self.channel


@pytest.fixture
def dialled(data: Path, channel: VisitChannel, monkeypatch: pytest.MonkeyPatch) -> Dialled:
    home_file(data).parent.mkdir(parents=True)
    home_file(data).touch()
    made = Dialled(channel)
    monkeypatch.setattr("sar_tui.link.visits.open_visits", made.open)
    return made


async def test_an_exercise_in_patient_mode_can_be_visited(
    opened: OpenApp,
    data: Path,
    dialled: Dialled,
    channel: VisitChannel,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(passphrase, "_COST", 16)
    Passphrase(data).set("quiet river")
    known(data, "P01")
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        assert dialled.opened == 1
        await asked(driver, channel)
        await driver.press("enter")
        await driver.wait(100)
        driver.see(SIGN)


async def test_what_hinders_a_visit_hinders_no_session(
    opened: OpenApp, data: Path, dialled: Dialled
) -> None:
    dialled.error = "The invitation expired."
    known(data, "P01")
    async with opened() as driver:
        await driver.press("enter", "enter")
        assert driver.screen_name == "SessionScreen"
        driver.see("The invitation expired.")


async def test_a_session_that_an_operator_may_join_is_not_visited(
    opened: OpenApp, data: Path, dialled: Dialled, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def local(*_: object) -> Iterator[FakeChannel]:
        yield FakeChannel()

    monkeypatch.setattr("sar_tui.link.listening.open_link", local)
    known(data, "P01", operator_joins=True)
    async with opened() as driver:
        await driver.press("enter", "enter")
        assert driver.screen_name == "SessionScreen"
    assert dialled.opened == 0


@pytest.mark.parametrize(
    ("settings", "people", "allowed"),
    [
        ({}, ["P01"], True),
        ({"operator_feedback": "autonomous"}, ["P01"], True),
        ({"operator_feedback": "approve"}, ["P01"], False),
        ({"operator_difficulty": "manual"}, ["P01"], False),
        ({"operator_joins": True}, ["P01"], False),
        ({}, ["P01", "P02"], False),
    ],
)
def test_sessions_with_a_wizard_and_of_two_people_are_not_visited(
    data: Path, settings: dict[str, Any], people: Sequence[str], allowed: bool
) -> None:
    with closing(connect(data)) as database:
        assert may_be_visited(database, settings, people, "") is allowed


@pytest.mark.parametrize(
    ("blind", "condition", "allowed"),
    [
        (False, {}, True),
        (True, {}, False),
        (False, {"operator_encouragement": "veto"}, False),
    ],
)
def test_sessions_of_a_study_with_a_wizard_or_blinding_are_not_visited(
    data: Path,
    blind: bool,
    condition: dict[str, Any],
    allowed: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = parse_plan(TWO_GROUPS, "plan.toml")
    conditions = plan.conditions | {"fast": replace(plan.conditions["fast"], settings=condition)}
    allocation = replace(plan.allocation, blind=blind)
    plan = replace(plan, conditions=conditions, allocation=allocation)
    known_plans = {plan.name: SimpleNamespace(plan=plan)}
    monkeypatch.setattr(ledger, "newest", lambda db, name: known_plans.get(name))
    with closing(connect(data)) as database:
        assert may_be_visited(database, {}, ["P01"], plan.name) is allowed
        assert not may_be_visited(database, {}, ["P01"], "unknown")
