"""Parameters of a task: parsing, clear errors for invalid values, and headings."""

import math
from typing import Annotated, Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import Meta

from sar_tui.rules.declaration import Field, ParameterError, meta, show
from sar_tui.rules.parameters import TaskParameters, build, changed, fields, grouped, usable
from tests.facts import each


class Parameters(TaskParameters, frozen=True, kw_only=True):
    """One parameter of each kind."""

    reach: Annotated[float, meta("Reach", "cm", "How far.", ge=0, le=100)] = 30.5
    repetitions: Annotated[int, meta("Repetitions", ge=1, le=12)] = 3
    hand: Annotated[Literal["left", "right"], meta("Hand")] = "right"
    mirrored: Annotated[bool, meta("Mirrored")] = False
    words: Annotated[tuple[str, ...], meta("Words")] = ("one", "two")
    nickname: Annotated[str, meta("Nickname", max_length=70)] = "x"
    code: Annotated[str, meta("Code", takes="two capitals, such as AB", pattern="^[A-Z]{2}$")] = (
        "AB"
    )
    marks: Annotated[tuple[float, ...], meta("Marks", min_length=2, max_length=3)] = (1.0, 2.0)
    waits: Annotated[
        tuple[Annotated[float, Meta(ge=0.2, le=3)], ...], meta("Waits", min_length=1, max_length=4)
    ] = (1.0,)
    undescribed: int = 4


FIELDS = {field.name: field for field in fields(Parameters)}


def problem(**values: object) -> str:
    with pytest.raises(ParameterError) as caught:
        build(Parameters, values)
    return str(caught.value)


def values_of(field: Field) -> st.SearchStrategy[Any]:
    low, high = field.ge, field.le
    word = st.text("abcdefghijklmnopqrstuvwxyz;.#é", min_size=1, max_size=4)
    whole = st.integers(-1000 if low is None else int(low), 1000 if high is None else int(high))
    return {
        "int": whole,
        "float": st.floats(low or 0, high or 1e6),
        "bool": st.booleans(),
        "choice": st.sampled_from(field.choices or ("",)),
        "list": st.lists(word, max_size=3).map(tuple),
        "text": word,
    }[field.kind]


OWN = ["reach", "repetitions", "hand", "mirrored", "words", "nickname", "undescribed"]


@st.composite
def own_values(draw: st.DrawFn) -> tuple[str, Any]:
    """Draw one of the task's own parameters, and a value for it."""
    name = draw(st.sampled_from(OWN))
    return name, draw(values_of(FIELDS[name]))


def test_a_declared_field_has_all_that_a_form_needs() -> None:
    assert FIELDS["reach"] == Field("reach", "Reach", "cm", "How far.", 30.5, "float", 0, 100)
    hand = Field("hand", "Hand", "", "", "right", "choice", choices=("right", "left"))
    assert FIELDS["hand"] == hand
    assert FIELDS["undescribed"] == Field("undescribed", "Undescribed", "", "", 4, "int")
    kinds = {name: FIELDS[name].kind for name in ("mirrored", "words", "nickname")}
    assert kinds == {"mirrored": "bool", "words": "list", "nickname": "text"}


def test_the_tasks_own_parameters_come_first() -> None:
    names = list(FIELDS)
    assert names.index("undescribed") == 9
    assert names[10:] == list(TaskParameters.__struct_fields__)


@pytest.mark.parametrize("field", fields(TaskParameters), ids=lambda field: field.name)
def test_every_common_parameter_has_a_title_a_heading_and_a_valid_default(field: Field) -> None:
    assert field.title != field.name
    assert field.group
    built = build(TaskParameters, {field.name: show(field.default)})
    assert getattr(built, field.name) == field.default


@given(own_values())
def test_a_value_is_equal_typed_and_given_and_stored_only_if_it_is_not_the_default(
    drawn: tuple[str, Any],
) -> None:
    name, value = drawn
    built = build(Parameters, {name: value})
    assert built == build(Parameters, {name: show(value)})
    assert getattr(built, name) == value
    changes = changed(built)
    assert set(changes) == ({name} if value != FIELDS[name].default else set())
    assert build(Parameters, changes) == built


@given(st.floats(), st.sampled_from(["reach", "threshold", "neutral_band", "min_accuracy"]))
def test_numbers_outside_their_bounds_are_refused(value: float, name: str) -> None:
    field = FIELDS[name]
    assert field.ge is not None
    assert field.le is not None
    for given_as in (value, repr(value)):
        if field.ge <= value <= field.le:
            assert getattr(build(Parameters, {name: given_as}), name) == value
        else:
            assert problem(**{name: given_as}).startswith(f"{field.title} is a number, ")


@given(st.text(), st.sampled_from(each(fields(Parameters), "name")))
def test_any_invalid_input_raises_one_sentence(text: str, name: str) -> None:
    problems: dict[str, str] = {}
    value: object = None
    try:
        value = getattr(build(Parameters, {name: text}), name)
    except ParameterError as error:
        problems = error.problems
    assert all(sentence.endswith(".") for sentence in problems.values())
    assert not isinstance(value, float) or math.isfinite(value)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"repetitions": 13}, "Repetitions is a whole number, 1 to 12, not 13."),
        ({"repetitions": "0"}, "Repetitions is a whole number, 1 to 12, not 0."),
        ({"repetitions": 2.5}, "Repetitions is a whole number, 1 to 12, not 2.5."),
        ({"repetitions": True}, "Repetitions is a whole number, 1 to 12, not yes."),
        ({"reach": "nan"}, "Reach is a number, 0 to 100, not nan."),
        ({"hand": "both"}, "Hand is one of right, left, not both."),
        ({"words": 5}, "Words takes space-separated words, not 5."),
        ({"marks": "1"}, "Marks takes 2 to 3 space-separated numbers, not 1."),
        ({"marks": "1 x"}, "Marks takes 2 to 3 space-separated numbers, not 1 x."),
        ({"waits": "0.5 7"}, "Waits takes 1 to 4 space-separated numbers 0.2 to 3, not 0.5 7."),
        ({"code": "ab"}, "Code takes two capitals, such as AB, not ab."),
        ({"nickname": "y" * 71}, f"Nickname takes at most 70 letters, not {'y' * 60}…."),
        (
            {"outputs": "a b c d e f g h i"},
            "Outputs takes at most 8 space-separated words, not a b c d e f g h i.",
        ),
        ({"mirrored": "perhaps"}, "Mirrored is yes or no, not perhaps."),
        ({"repetition": 2}, "There is no parameter repetition. Did you mean repetitions?"),
        ({"qqq": 2}, "There is no parameter qqq."),
        ({"min_level": 6, "max_level": 5}, "Lowest level (6) is above the highest (5)."),
        ({"start_level": 6, "max_level": 5}, "Start level (6) must be between 1 and 5."),
        ({"start_level": 2, "min_level": 3}, "Start level (2) must be between 3 and 10."),
        (
            {"foreperiod_min_ms": 900, "foreperiod_max_ms": 800},
            "Shortest wait (900 ms) is above the longest (800 ms).",
        ),
        (
            {"system_keys": "slow"},
            "With slow keys, the delay of the system is 1 ms or more.",
        ),
        (
            {"system_keys": "neither", "added_delay_ms": 300},
            "A delay of 300 ms is that of slow keys: choose slow.",
        ),
    ],
)
def test_each_invalid_value_is_reported_in_one_sentence(
    values: dict[str, object], sentence: str
) -> None:
    assert problem(**values) == sentence


def test_every_problem_is_reported_not_only_the_first() -> None:
    with pytest.raises(ParameterError) as caught:
        build(Parameters, {"repetitions": 0, "hand": "both", "nonsense": 1})
    assert set(caught.value.problems) == {"repetitions", "hand", "nonsense"}


def test_bounds_are_inclusive_and_list_items_separated_by_spaces_or_commas() -> None:
    built = build(Parameters, {"repetitions": "12", "words": " fj, dfjk  asdf "})
    assert (built.repetitions, built.words) == (12, ("fj", "dfjk", "asdf"))
    assert build(Parameters, {"repetitions": 1}).repetitions == 1


@pytest.mark.parametrize("returned", [["a list"], None, 5])
def test_a_check_of_a_task_that_fails_is_a_problem_of_its_settings(returned: object) -> None:
    class Unchecked(Parameters, frozen=True, kw_only=True):
        def problems(self) -> Any:
            return 1 / 0 if returned == 5 else returned

    with pytest.raises(
        ParameterError, match=r"The settings cannot be checked: problems\(\) failed \(\w+Error: "
    ):
        build(Unchecked, {})


# --- headings


class GroupedParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters with additional headings, and with common parameters declared again."""

    drum: Annotated[bool, meta("Drum", group="Music")] = True
    reach: Annotated[float, meta("Reach", ge=0, le=100)] = 30.5
    slack_ms: Annotated[int, meta("Slack", "ms", group="Timing", ge=0, le=100)] = 10
    threshold: Annotated[float, meta("Goal", "cm", ge=0, le=100)] = 20.0
    rest_every: Annotated[int, meta("Rest", group="Music", ge=0, le=9)] = 2


def test_each_parameter_stands_under_one_heading_and_a_task_may_add_headings() -> None:
    common = [
        "Session",
        "Limits",
        "Difficulty",
        "Feedback",
        "Access",
        "Agent",
        "Operator",
        "Timing",
    ]
    usual, own = grouped(TaskParameters), grouped(GroupedParameters)
    assert list(usual) == sorted(usual, key=common.index)
    assert list(own) == ["", "Music", *usual]
    placed = [name for heading in own for name in each(own[heading], "name")]
    assert sorted(placed) == sorted(each(fields(GroupedParameters), "name"))
    assert each(own[""], "name") == ["reach"]
    assert each(own["Music"], "name") == ["drum", "rest_every"]
    assert each(own["Timing"], "name")[0] == "slack_ms"


def test_a_redeclared_common_parameter_keeps_its_heading_and_position() -> None:
    difficulty = grouped(GroupedParameters)["Difficulty"]
    assert each(difficulty, "name") == each(grouped(TaskParameters)["Difficulty"], "name")
    goal = difficulty[0]
    assert (goal.name, goal.unit, goal.default) == ("threshold", "cm", 20.0)


def test_values_that_became_unusable_are_left_out_with_the_reason_and_the_rest_is_kept() -> None:
    saved = {"attempts": 12, "rest_every": 9999, "tempo": 3, "min_level": 3, "start_level": 2}
    kept, left_out = usable(TaskParameters, saved)
    assert kept == {"attempts": 12}
    assert left_out == {
        "rest_every": "Rest reminder every is a whole number, 0 to 200, not 9999.",
        "tempo": "The setting tempo does not exist any more.",
        "start_level": "Start level (2) must be between 3 and 10.",
        "min_level": "Start level (1) must be between 3 and 10.",
    }
    assert usable(TaskParameters, kept) == (kept, {})


def test_slow_keys_that_nobody_asked_about_are_told_from_none() -> None:
    assert TaskParameters().system_keys == "not asked"
    assert changed(build(TaskParameters, {"system_keys": "neither"})) == {"system_keys": "neither"}


def test_a_delay_without_slow_keys_leaves_out_no_other_setting_of_access() -> None:
    saved = {"switch": "one", "added_delay_ms": 300}
    assert usable(TaskParameters, saved)[0] == {"switch": "one"}
