"""The operator's protocol: its file, its small language, and when something is due."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model import messages as m
from sar_tui.model.protocol import REASONS, Condition, ProtocolRule, ProtocolStep, WizardProtocol
from sar_tui.model.toml_lines import Mistake
from sar_tui.operator.phrases import PHRASE_KEYS
from sar_tui.rules.protocol import ProtocolProgress, step, unit_factor, verdict_on
from sar_tui.rules.protocol_file import (
    MAX_BYTES,
    Deed,
    ProtocolMistakes,
    parse,
    parse_condition,
    parse_deed,
)
from tests.operator.panel_driver import attempt as ended_attempt
from tests.operator.panel_driver import proposal as a_proposal
from tests.operator.panel_driver import trial

GOOD = """
name = "encourage"
version = 2
late_after_s = 20
phrases = ["Take your time.", "That was {result}."]

[reasons]
1 = "too early"
9 = "other"

[[steps]]
at = "start"
do = "say greeting"

[[steps]]
at = "after  attempt 3"
do = 'say Keep on like this!'

[[steps]]
at = "pause"
do = "Ask whether the hand hurts."

[[rules]]
when = "accuracy < 60 % twice in a row"
do = "say phrase 1"
"""


def test_a_protocol_is_read_with_its_hash() -> None:
    protocol = parse(GOOD.encode(), ("greeting",))
    assert (protocol.name, protocol.version, protocol.late_after_s) == ("encourage", 2, 20)
    assert [(each.at, each.attempt, each.do) for each in protocol.steps] == [
        ("start", 0, "say greeting"),
        ("after attempt", 3, "say Keep on like this!"),
        ("pause", 0, "Ask whether the hand hurts."),
    ]
    assert protocol.rules[0].when == Condition("accuracy", "<", 60, "", 2, in_a_row=True)
    assert [(each.code, each.text) for each in protocol.reasons] == [(1, "too early"), (9, "other")]
    assert len(protocol.hash) == 64
    assert parse(GOOD.encode() + b"\n").hash != protocol.hash
    assert (
        parse(b'name="a"\nversion=1\n[[steps]]\nat="end"\ndo="Say thank you."').reasons == REASONS
    )


def test_the_documented_protocol_is_one() -> None:
    page = Path(__file__).parents[2] / "docs" / "run-a-wizard-of-oz-study.md"
    text = page.read_text(encoding="utf-8").partition("### Work by a protocol")[2]
    source = text.partition("```toml\n")[2].partition("```")[0]
    protocol = parse(source.encode(), PHRASE_KEYS)
    assert (len(protocol.steps), len(protocol.rules)) == (1, 1)


@pytest.mark.parametrize(
    ("source", "line", "why"),
    [
        ("name = ", 1, "not valid TOML"),
        ('name = "a"\nversion = 1\n', 1, "no [[steps]] and no [[rules]]"),
        (GOOD.replace('"encourage"', '"En courage"'), 2, "name must be a word"),
        (GOOD.replace("version = 2", 'version = "2"'), 3, "version must be a whole number"),
        (GOOD.replace("late_after_s = 20", "late_after_s = 0"), 4, "from 1 to 600"),
        (GOOD.replace('"Take your time."', '""'), 5, "phrases must be"),
        (GOOD.replace("9 = ", "no = "), 7, "reasons must be digits"),
        (GOOD.replace('at = "start"', 'at = "begin"'), 12, "'begin' is not a moment"),
        (GOOD.replace("say greeting", "say greting"), 13, "'greting' is no key of a phrase"),
        (GOOD.replace("say greeting", "greet"), 13, "neither a sentence"),
        (GOOD.replace("say greeting", "veto words"), 13, "no proposals 'words'"),
        (GOOD.replace("say greeting", "level up"), 13, "'level up' is not a level"),
        (GOOD.replace("say greeting", "gesture"), 13, "does not say what"),
        (GOOD.replace('at = "pause"', 'at = "attempt 2"'), 19, "in the order"),
        (GOOD.replace('at = "pause"', 'when = "pause"'), 20, "'when' is not known"),
        (GOOD.replace("accuracy", "speed"), 24, "no measure 'speed'"),
        (GOOD.replace("say phrase 1", "say phrase 3"), 25, "There is no phrase 3"),
        (GOOD.replace("say phrase 1", "say phrase 0"), 25, "There is no phrase 0"),
        (GOOD.replace('at = "pause"', 'at = "attempt 3"'), 19, "in the order"),
        (GOOD + 'if = "x"\n', 26, "'if' is not known"),
        ("#" * (MAX_BYTES + 1), 1, "bytes"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_line(source: str, line: int, why: str) -> None:
    with pytest.raises(ProtocolMistakes) as caught:
        parse(source.encode(), ("greeting",))
    assert line in [each.line for each in caught.value.mistakes], caught.value.mistakes
    assert why in str(caught.value)


def test_all_mistakes_are_named_at_once_in_order() -> None:
    source = GOOD.replace('"encourage"', "1").replace("accuracy", "speed").replace("start", "x")
    with pytest.raises(ProtocolMistakes) as caught:
        parse(source.encode())
    lines = [each.line for each in caught.value.mistakes]
    assert lines == [2, 12, 24]


@given(st.binary(max_size=300) | st.text(max_size=300).map(str.encode))
def test_no_file_crashes_the_reader(source: bytes) -> None:
    mistakes: list[Mistake] = []
    try:
        parse(source)
    except ProtocolMistakes as error:
        mistakes = error.mistakes
    assert all(each.line >= 1 and each.why.endswith(".") for each in mistakes)


@pytest.mark.parametrize(
    ("text", "condition"),
    [
        ("accuracy<60%", Condition("accuracy", "<", 60)),
        ("metric >= 812.5 ms 3 times", Condition("metric", ">=", 812.5, "ms", 3)),
        ("success = no twice", Condition("success", "=", 0, "", 2)),
        ("timeouts > 2 2 times in a row", Condition("timeouts", ">", 2, "", 2, in_a_row=True)),
        ("pain > 5", Condition("pain", ">", 5)),
    ],
)
def test_conditions(text: str, condition: Condition) -> None:
    assert parse_condition(text) == condition


@pytest.mark.parametrize(
    "text",
    [
        "", "accuracy", "accuracy < ", "accuracy < x", "accuracy < 101", "accuracy < 60 ms",
        "accuracy != 60", "success < 1", "success = maybe", "pain > 11", "level = 1.5",
        "level > 3 in a row", "level > 3 once", "level > 3 0 times", "level > 3 twice in row",
        "metric > 3 ms thrice", "level > 3 & pain > 2", "60 > accuracy",
    ],
)  # fmt: skip
def test_what_is_no_condition_is_refused_with_a_sentence(text: str) -> None:
    with pytest.raises(ValueError, match=r"\.$"):
        parse_condition(text)


def test_deeds() -> None:
    assert parse_deed("say greeting", 0) == Deed("key", "greeting")
    assert parse_deed("say Bravo!", 0) == Deed("say", "Bravo!")
    assert parse_deed("say phrase 2", 2) == Deed("phrase", number=2)
    assert parse_deed("gesture thumbs up", 0) == Deed("gesture", "thumbs_up")
    assert parse_deed("level -1", 0) == Deed("level by", number=-1)
    assert parse_deed("level 4", 0) == Deed("level", number=4)
    assert parse_deed("veto level", 0) == Deed("veto", kind="difficulty")
    assert parse_deed("Offer a glass of water.", 0) == Deed("other", "Offer a glass of water.")


# --- what is due


def begun(number: int) -> m.AttemptStarted:
    return m.AttemptStarted(attempt=number, practice=False, level=1, trials=4)


def ended(number: int, **more: Any) -> m.AttemptEnded:
    return ended_attempt(**{"attempt": number, **more})


def waiting(stage: Any) -> m.Waiting:
    return m.Waiting(what="enter", stage=stage, attempt=1, trial=0, level=1)


def answered(name: str, answer: Any) -> m.StepEnded:
    return m.StepEnded(
        number=1, attempt=1, name=name, kind="number", text="?", status="answered", answer=answer,
        shown=0, ended=1,
    )  # fmt: skip


def protocol(*rules: str, steps: tuple[ProtocolStep, ...] = ()) -> WizardProtocol:
    made = tuple(ProtocolRule(parse_condition(each), each, "Say so.") for each in rules)
    return WizardProtocol("p", 1, "h", steps=steps, rules=made)


def run(messages: list[m.Message]) -> list[m.ProtocolDue]:
    progress, found = ProtocolProgress(), []
    for at, message in enumerate(messages):
        progress, due = step(progress, message, at)
        found += due
    return found


def due_after(messages: list[m.Message]) -> list[tuple[int, str, int]]:
    """Return what is due: the place of the message that made it due, what, and its number."""
    return [(each.at, each.what, each.number) for each in run(messages)]


STEPS = (
    ProtocolStep("start", "say greeting"),
    ProtocolStep("attempt", "Watch.", 2),
    ProtocolStep("after attempt", "Praise them.", 2),
    ProtocolStep("pause", "Ask why."),
    ProtocolStep("end", "Say goodbye."),
)


def test_steps_are_due_in_their_order() -> None:
    chosen = m.ProtocolChosen(protocol=protocol(steps=STEPS))
    pause = [waiting("paused"), waiting("paused"), waiting("attempt")]
    end = [waiting("review"), m.SessionEnded(status="completed")]
    attempts = [begun(1), ended(1), begun(2), ended(2), ended(2, accuracy=0.1)]
    messages = [chosen, *attempts, *pause, *pause, *end]
    assert [each.attempt for each in run(messages)] == [0, 2, 2, 2, 2, 2], "begun last"
    assert due_after(messages) == [
        (0, "step", 1),
        (3, "step", 2),
        (4, "step", 3),
        (6, "step", 4),
        (9, "step", 4),
        (12, "step", 5),
    ]


def test_a_protocol_that_comes_late_begins_with_what_is_to_come() -> None:
    chosen = m.ProtocolChosen(protocol=protocol(steps=STEPS))
    assert due_after([begun(1), ended(1), begun(2), chosen, ended(2)]) == [(4, "step", 3)]
    assert due_after([begun(1), ended(1), begun(2), ended(2), chosen, begun(3)]) == []


def test_a_step_is_not_lost_with_the_number_of_an_interrupted_attempt() -> None:
    chosen = m.ProtocolChosen(protocol=protocol(steps=STEPS[1:2]))
    assert due_after([chosen, begun(1), begun(3)]) == [(2, "step", 2 - 1)]


def test_rules_of_a_protocol_that_is_chosen_again_count_from_zero() -> None:
    chosen = m.ProtocolChosen(protocol=protocol("accuracy < 60 % twice"))
    first, second, third = accuracies(0.5, 0.5, 0.5)
    assert due_after([chosen, first, chosen, second, third]) == [(4, "rule", 1)]


def accuracies(*values: float | None) -> list[m.Message]:
    return [ended(number, accuracy=value) for number, value in enumerate(values, 1)]


def test_times_and_times_in_a_row() -> None:
    twice = m.ProtocolChosen(protocol=protocol("accuracy < 60 % twice"))
    assert due_after([twice, *accuracies(0.5, 0.9, 0.5, 0.5, 0.6, 0.5)]) == [
        (3, "rule", 1),
        (6, "rule", 1),
    ]
    row = m.ProtocolChosen(protocol=protocol("accuracy < 60 % twice in a row"))
    assert due_after([row, *accuracies(0.5, 0.9, 0.5, 0.5, 0.5)]) == [(4, "rule", 1)]
    assert due_after([row, *accuracies(0.5, None, 0.5)]) == [(3, "rule", 1)], "nothing was measured"


def test_practice_and_attempts_that_are_scored_again_do_not_count() -> None:
    chosen = m.ProtocolChosen(protocol=protocol("success = no"))
    fails = ended(1, outcome="failure", practice=True), ended(2, outcome="failure")
    assert due_after([chosen, *fails, fails[1]]) == [(2, "rule", 1)]


def test_measures() -> None:
    def holds(rule: str, *messages: m.Message) -> bool:
        return bool(run([m.ProtocolChosen(protocol=protocol(rule)), *messages]))

    assert holds("metric > 0.4 s", ended(1, metric=498.2))
    assert not holds("metric > 0.4 m", ended(1, metric=498.2)), "other kinds of unit never hold"
    assert holds("level = 4", ended(1))
    assert holds("success = yes", ended(1))
    assert not holds("success = yes", ended(1, outcome="none"))
    assert not holds("success = no", ended(1, outcome="none"))
    misses = [trial(1, "f", None), trial(2, "f", None), trial(3, "f", 300)]
    assert holds("timeouts >= 2", begun(1), *misses, ended(1))
    assert not holds("timeouts >= 2", begun(1), *misses, begun(2), ended(2))
    assert holds("pain > 5", answered("pain", 6))
    assert not holds("pain > 5", answered("effort", 6), answered("pain", None), ended(1))


def test_each_participant_has_their_own_count() -> None:
    chosen = m.ProtocolChosen(protocol=protocol("accuracy < 60 % twice"))
    both = [ended(n, seat=seat, accuracy=0.5) for n in (1, 2) for seat in "AB"]
    assert [(each.seat, each.at) for each in run([chosen, *both])] == [("A", 3), ("B", 4)]


@pytest.mark.parametrize(
    ("do", "what", "verdict"),
    [
        ("veto feedback", "rule", {"feedback A": "", "feedback B": "veto", "rest A": ""}),
        ("approve feedback", "step", {"feedback A": "accept", "feedback B": "accept"}),
        ("veto instruction", "rule", {"feedback B": "", "instruction A": "veto"}),
        ("Offer water.", "rule", {"feedback B": "", "rest A": "", "gesture A": ""}),
    ],
)
def test_what_is_due_decides_on_proposals_of_its_kind_and_a_rule_on_its_own_participants_feedback(
    do: str, what: Any, verdict: dict[str, str]
) -> None:
    due = m.ProtocolDue(seat="B", id="d1", what=what, number=1, attempt=1, do=do)
    for proposal, expected in verdict.items():
        kind, seat = proposal.split()
        proposed = a_proposal(kind=kind, seat=seat)
        assert verdict_on(proposed, due, protocol("level = 4")) == expected, proposal


def test_units_of_time_are_converted() -> None:
    assert unit_factor("ms", "s") == 0.001
    assert unit_factor("s", "ms") == 1000
    assert unit_factor("cm", "") == unit_factor("cm", "cm") == 1
    assert unit_factor("cm", "s") is None


MESSAGES = st.lists(
    st.one_of(
        st.integers(1, 6).map(begun),
        st.builds(ended, st.integers(1, 6), accuracy=st.sampled_from([0.2, 0.7, None])),
        st.sampled_from(["paused", "attempt", "review"]).map(waiting),
        st.just(m.ProtocolChosen(protocol=protocol("accuracy < 60 %", "level = 4", steps=STEPS))),
        st.integers(0, 10).map(lambda value: answered("pain", value)),
    ),
    max_size=30,
)


@given(MESSAGES, st.integers(0, 30))
def test_what_is_due_follows_from_the_messages_alone_and_from_any_point_on(
    messages: list[m.Message], cut: int
) -> None:
    whole = run(messages)
    assert run(messages) == whole
    progress, first = ProtocolProgress(), []
    for at, message in enumerate(messages[:cut]):
        progress, due = step(progress, message, at)
        first += due
    for at, message in enumerate(messages[cut:], len(messages[:cut])):
        progress, due = step(progress, message, at)
        first += due
    assert first == whole
    assert all(before.id != after.id for before, after in pairwise(whole))
    assert [each.id for each in whole] == [f"d{number + 1}" for number in range(len(whole))]
