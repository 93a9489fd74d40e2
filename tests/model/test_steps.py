"""Steps between attempts: what is due, how keys answer a question, and what a file may declare."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.step import DECLINE_KEY, Entry, Given, Step, points, press, problem
from sar_tui.rules.questions import EARLIER, StepFileError, chosen, read_steps
from sar_tui.simulation.participant import answer_keys
from tests.examples import examples

NUMBER = Step(name="pain", text="How strong?", kind="number", labels=("none", "worst"))
BORG = EARLIER["effort"]
LIKERT = Step(name="fun", text="It was fun.", kind="likert", labels=("no", "a little", "yes"))
LINE = Step(name="mood", text="How are you?", kind="line")
CHOICES = Step(name="where", text="Where?", kind="choices", labels=("hand", "arm", "shoulder"))
TEXT = Step(name="word", text="Anything else?", kind="text")
ASKED = (NUMBER, BORG, LIKERT, LINE, CHOICES, TEXT)


def keyed(step: Step, *keys: str) -> Entry | Given:
    entry: Entry | Given = Entry()
    for key in keys:
        assert isinstance(entry, Entry)
        entry = press(step, entry, key)
    return entry


@pytest.mark.parametrize("step", ASKED, ids=lambda step: step.kind)
def test_nothing_is_chosen_before_a_key_chooses_it(step: Step) -> None:
    assert keyed(step, "enter") == Entry(is_missing=True)
    assert keyed(step, DECLINE_KEY) == Given("declined", None)
    assert problem(step) == ""


@pytest.mark.parametrize(
    ("step", "keys", "answer"),
    [
        (NUMBER, "0", 0),
        (NUMBER, "10", 10),
        (NUMBER, "17", 7),  # there is no 17: the 7 begins anew
        (NUMBER, ("right",), 0),
        (NUMBER, ("left",), 10),
        (NUMBER, ("4", "right", "right", "left"), 5),
        (NUMBER, ("left", "right"), 10),
        (BORG, "0.5", 0.5),
        (BORG, "2,5", 2.5),
        (BORG, "11", 11),
        (BORG, ("up",), 11),
        (LIKERT, "2", 2),
        (LIKERT, ("enter", "2"), 2),
        (LIKERT, ("down", "down"), 2),
        (LINE, ("right",), 0),
        (LINE, ("left",), 100),
        (LINE, ("5", "right", "up"), 61),
        (LINE, ("9", "up", "up"), 100),
        (CHOICES, "31", ("hand", "shoulder")),
        (CHOICES, ("down", "space", "down", "space", "1"), ("arm",)),
        (TEXT, ("o", "x", "backspace", "k", "space", "!"), "ok !"),
        (TEXT, ("space", "é"), "é"),
    ],
)
def test_keys_choose_an_answer_that_enter_gives(
    step: Step, keys: str | tuple[str, ...], answer: object
) -> None:
    assert keyed(step, *keys, "enter") == Given("answered", answer)


@pytest.mark.parametrize("key", ["x", "f5", "pageup", "0", "4"])
def test_keys_that_mean_nothing_change_nothing(key: str) -> None:
    assert keyed(LIKERT, "2", key) == keyed(LIKERT, "2")
    assert keyed(TEXT, "space", "enter") == Entry(typed=" ", is_missing=True)


KEYS = (*"0123456789., xé", *"up down left right space backspace home end enter".split())


@examples(200)
@given(st.sampled_from(ASKED), st.lists(st.sampled_from(KEYS), max_size=12))
def test_any_keys_give_an_answer_of_the_question_or_none(step: Step, keys: list[str]) -> None:
    entry: Entry | Given = Entry()
    for key in keys:
        if isinstance(entry, Given):
            break
        entry = press(step, entry, key)
    if isinstance(entry, Given):
        known = {point.value for point in points(step)}
        match step.kind:
            case "line":
                assert entry.answer in range(101)
            case "text":
                assert str(entry.answer).strip()
            case "choices":
                assert isinstance(entry.answer, tuple)
                assert set(entry.answer) <= known
            case _:
                assert entry.answer in known


@pytest.mark.parametrize(
    ("when", "due"),
    [
        ({}, [4]),
        ({"before": True}, [0]),
        ({"every": 2}, [2, 4]),
        ({"after": (1, 3)}, [1, 3]),
        ({"every": 3, "at_end": True}, [3, 4]),
        ({"before": True, "at_end": True}, [0, 4]),
    ],
)
def test_a_step_is_due_before_after_or_between_attempts(
    when: dict[str, object], due: list[int]
) -> None:
    step = Step(name="a", text="A", **when)  # type: ignore[arg-type]
    assert [done for done in range(5) if step.is_due(done, 4)] == due


def test_questions_of_the_settings_come_after_so_many_attempts_or_after_the_last() -> None:
    assert [step.is_due(2, 4) for step in chosen(("pain", "exertion"), 2)] == [True, True]
    assert [done for done in range(5) if chosen(("pain",), 0)[0].is_due(done, 4)] == [4]


@pytest.mark.parametrize("step", ASKED, ids=lambda step: step.kind)
def test_simulated_people_answer_in_many_ways(step: Step) -> None:
    given_answers = set()
    for seed in range(60):
        given_answer = keyed(step, *answer_keys(step, RandomStreams(seed)))
        assert isinstance(given_answer, Given)
        given_answers.add(given_answer)
    assert len(given_answers) > 2
    assert any(each.status == "declined" for each in given_answers)


@pytest.mark.parametrize(
    ("written", "why"),
    [
        ('name="a b"\ntext="A"', "The name of a step is letters, digits, - and _"),
        ('name="a"\ntext=" "', "has no text"),
        ('name="a"\ntext="A"\nkind="likert"', "needs 2 to 9 labels, and has 0"),
        ('name="a"\ntext="A"\nkind="choice"\nlabels=["x","x"]', "each label is a different word"),
        ('name="a"\ntext="A"\nkind="number"\nlabels=["x"]', "needs two labels"),
        ('name="a"\ntext="A"\nkind="text"\nlabels=["x"]', "has no labels"),
        ('name="a"\ntext="A"\nkind="rest"', "lasts seconds"),
        ('name="a"\ntext="A"\nseconds=3', "has no seconds"),
        ('name="a"\ntext="A"\nevery=-1', "every is 0 or more"),
        ('name="a"\ntext="A"\nkind="slider"', "line 4: Invalid enum value 'slider'"),
        ('name="a"\ntext="A"\nwhen=3', "line 4: There is nothing named when here"),
        ('name="a"\ntext="A"\n[[steps]]\nname="a"\ntext="B"', "Two steps are named"),
    ],
)
def test_a_file_whose_steps_cannot_be_used_is_refused_in_a_sentence(
    tmp_path: Path, written: str, why: str
) -> None:
    file = tmp_path / "steps.toml"
    file.write_text(f"[[steps]]\n{written}\n")
    with pytest.raises(StepFileError, match=why):
        read_steps(file)


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StepFileError, match="cannot be read"):
        read_steps(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(StepFileError):
        read_steps(tmp_path / "bytes.toml")
