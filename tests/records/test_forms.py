"""Forms are kinds of record with items, scores, words by language, and a permission."""

from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.records import kind as kinds_room
from sar_tui.records.kind import (
    NOT_SAID,
    SHIPPED,
    Kind,
    KindError,
    RecordError,
    Value,
    find,
    read_kind,
)
from sar_tui.records.scoring import compute

FORM = """
name = "mood"
title = "Mood"
entered_by = "participant"
[form]
items = 4
lowest = 1
highest = 7
reversed = [4]
[[scores]]
name = "all"
rule = "sum"
missing = "others"
at_least = 3
[[scores]]
name = "part"
items = [1, 4]
[words.en]
items = ["A", "B", "C", "D"]
labels = ["no", "yes"]
[words.de]
items = ["E", "F", "G", "H"]
"""
MANY_LABELS = FORM.replace("highest = 7", "highest = 40").replace(
    '["no", "yes"]', f"{[str(number) for number in range(40)]}"
)
TEXTS = """
based_on = "KSS"
permission = "The authors, by e-mail, 2026-03-01"
[words.en]
items = ["How sleepy are you?"]
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a laboratory's own kinds, with a form in it."""
    monkeypatch.setattr(kinds_room, "own_folder", lambda: tmp_path)
    (tmp_path / "mood.toml").write_text(FORM, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    return tmp_path


def answered(kind: Kind, *values: Value) -> Mapping[str, Value]:
    return {item.name: value for item, value in zip(kind.items, values, strict=False)}


def score(kind: Kind, *values: Value) -> object:
    return kind.read(answered(kind, *values)).get("score")


def test_the_usability_scale_is_scored_as_published() -> None:
    sus = find("SUS")
    assert score(sus, *[5, 1] * 5) == 100
    assert score(sus, *[1, 5] * 5) == 0
    assert score(sus, *[3] * 10) == 50
    assert score(sus, 4, 2, 4, 1, 5, 2, 4, 2, 4, 3) == 77.5
    assert score(sus, *[5, 1] * 4, 5, NOT_SAID) == 95, "a missing item counts as the middle"
    assert "score" not in sus.read(answered(sus, *[NOT_SAID] * 10)), "of nothing there is no score"


@given(st.lists(st.integers(1, 5), min_size=10, max_size=10))
def test_the_usability_scale_follows_its_recipe_for_all_answers(values: list[int]) -> None:
    odd = sum(value - 1 for value in values[::2])
    even = sum(5 - value for value in values[1::2])
    assert score(find("SUS"), *values) == (odd + even) * 2.5


def test_the_workload_is_the_mean_of_six_scales_in_steps_of_five() -> None:
    tlx = find("nasa-tlx")
    assert tlx.items[0].points == tuple(range(0, 101, 5))
    assert tlx.items[3].labels == ("Perfect", "Failure")
    assert score(tlx, 0, 100, 50, 25, 75, 5) == 42.5
    assert score(tlx, 0, 100, 50, 25, 75, NOT_SAID) is None
    with pytest.raises(RecordError, match=r"goes in steps of 5 from 0, so it is not 42\."):
        tlx.read(answered(tlx, 42))


def numbered(kind: Kind, values: Mapping[int, int], usual: int) -> dict[str, Value]:
    """Return answers by the number of their item; all others are the usual one."""
    return {f"q{number}": values.get(number, usual) for number in range(1, len(kind.items) + 1)}


def scores(kind: Kind, values: Mapping[int, int], usual: int) -> dict[str, Value]:
    found = kind.read(numbered(kind, values, usual))
    return {score.name: found[score.name] for score in kind.scores}


def test_the_user_experience_goes_from_minus_three_to_three() -> None:
    """The best answer is 7 of an item, and 1 of one whose good word comes first."""
    ueq = find("UEQ")
    reversed_items = (3, 4, 5, 9, 10, 12, 17, 18, 19, 21, 23, 24, 25)
    assert set(scores(ueq, dict.fromkeys(reversed_items, 1), 7).values()) == {3.0}
    assert set(scores(ueq, dict.fromkeys(reversed_items, 7), 1).values()) == {-3.0}
    assert scores(ueq, {2: 6, 4: 3, 13: 5, 21: 1, 26: 1}, 4) == {
        "attractiveness": 0.0,
        "perspicuity": (2 + 1 + 1 + 3) / 4,
        "efficiency": 0.0,
        "dependability": 0.0,
        "stimulation": 0.0,
        "novelty": -3 / 4,
    }
    field = ueq.field("novelty")
    assert (field.lowest, field.highest) == (-3.0, 3.0)


def test_the_motivation_inventory_reverses_six_of_its_items() -> None:
    answers = {1: 7, 5: 6, 8: 5, 10: 7, 14: 1, 17: 6, 20: 3, 11: 2, 19: 1, 21: 3, 2: 6, 9: 7}
    assert scores(find("IMI"), answers, 4) == {
        "interest": pytest.approx((7 + 6 + 5 + 7 + (8 - 1) + 6 + 3) / 7, abs=1e-6),
        "competence": 4.0,
        "choice": (4 + (8 - 2) + 4 + (8 - 1) + (8 - 3)) / 5,
        "tension": ((8 - 6) + 4 + (8 - 7) + 4 + 4) / 5,
    }


def test_affect_has_two_sums_of_ten_items() -> None:
    panas = find("PANAS")
    positive = dict.fromkeys((1, 3, 5, 9, 10, 12, 14, 16, 17, 19), 5)
    assert scores(panas, positive, 1) == {"positive": 50, "negative": 10}
    assert scores(panas, {1: 5, 2: 4}, 2) == {"positive": 5 + 9 * 2, "negative": 4 + 9 * 2}
    assert (panas.field("positive").lowest, panas.field("positive").highest) == (10, 50)


def test_attitudes_to_robots_have_three_sums_and_the_third_is_reversed() -> None:
    answers = {4: 5, 7: 1, 8: 2, 9: 5, 10: 4, 12: 3, 1: 5, 14: 1, 3: 4, 5: 5, 6: 1}
    assert scores(find("NARS"), answers, 3) == {
        "interaction": 5 + 1 + 2 + 5 + 4 + 3,
        "influence": 5 + 3 + 3 + 3 + 1,
        "emotions": (6 - 4) + (6 - 5) + (6 - 1),
    }


def test_attributes_of_a_robot_have_three_means_of_six() -> None:
    answers = {1: 9, 2: 8, 6: 1, 7: 9, 18: 1}
    assert scores(find("RoSAS"), answers, 5) == {
        "warmth": pytest.approx((9 + 8 + 5 + 5 + 5 + 1) / 6, abs=1e-6),
        "competence": pytest.approx((9 + 5 * 5) / 6, abs=1e-6),
        "discomfort": pytest.approx((5 * 5 + 1) / 6, abs=1e-6),
    }


def test_a_form_in_one_other_language_is_stored_in_that(own: Path) -> None:
    text = TEXTS.replace("[words.en]", "[words.de]")
    (own / "kss.toml").write_text(text, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    kss = find("KSS")
    assert (kss.why_unusable, kss.languages) == ("", ("de",))
    assert [kss.language_shown(code) for code in ("en", "de", "es")] == ["de"] * 3


def test_a_declaration_with_its_own_words_counts_as_english(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(CHOICE, encoding="utf-8")
    hand = read_kind(tmp_path / "own.toml")
    assert hand.languages == ("en", "de")
    assert hand.in_language("en").items[0].labels == ("left", "right")
    assert hand.in_language("de").items[0].labels == ("links", "rechts")


def test_items_that_have_the_same_labels_and_no_text_cannot_be_asked(own: Path) -> None:
    text = 'based_on = "FSS"\npermission = "x"\n[words.en]\nlabels = ["no", "yes"]\n'
    (own / "fss.toml").write_text(text, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    assert "The text of FSS is not here" in find("FSS").why_unusable


def test_the_last_answer_completes_a_form_also_as_a_correction() -> None:
    sus = find("SUS")
    begun = sus.read({**answered(sus, *[3] * 9), "status": "open"})
    assert "score" not in begun
    assert sus.read({**begun, "q10": 3})["status"] == "complete"
    assert sus.read({**begun, "q10": 3})["score"] == 50


def test_a_score_says_how_many_items_are_missing_and_what_it_needs(own: Path) -> None:
    mood = find("mood")
    found = mood.read(answered(mood, 1, 2, NOT_SAID, 2))
    assert (found["all"], found["all_missing"]) == (12.0, 1), "(1 + 2 + 6) / 3 * 4"
    assert (found["part"], found["part_missing"]) == (3.5, 0)
    found = mood.read(answered(mood, 1, 2, NOT_SAID, NOT_SAID))
    assert "all" not in found
    assert (found["all_missing"], found["part_missing"]) == (2, 1)
    assert mood.read({**answered(mood, 1, 2), "status": "open"}) == {
        "q1": 1, "q2": 2, "status": "open",
    }  # fmt: skip
    again = mood.read(mood.read(answered(mood, 1, 2, 3, 4)))
    assert again["all"] == mood.read(answered(mood, 1, 2, 3, 4))["all"], "scores are never typed"
    with pytest.raises(RecordError, match="Mood has no answers"):
        mood.read({})


def test_a_form_has_words_in_several_languages(own: Path) -> None:
    mood = find("mood")
    assert [item.title for item in mood.items] == ["A", "B", "C", "D"]
    german = mood.in_language("de")
    assert [item.title for item in german.items] == ["E", "F", "G", "H"]
    assert german.items[0].labels == ("no", "yes")
    assert [item.title for item in mood.in_language("es").items] == ["A", "B", "C", "D"]
    for name in ("effort", "fatigue", "pain-now"):
        assert set(find(name).languages) == {"en", "de", "es"}


def test_a_key_is_used_with_the_text_and_the_permission_of_the_laboratory(own: Path) -> None:
    assert "The text of KSS is not here" in find("KSS").why_unusable
    (own / "kss.toml").write_text(TEXTS, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    kss = find("KSS")
    assert kss.why_unusable == ""
    assert kss.read({"q1": 7})["permission"] == "The authors, by e-mail, 2026-03-01"
    (own / "kss.toml").write_text(TEXTS.replace("permission", "licence"), encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    assert "KSS may be used only if its owner allows it" in find("KSS").why_unusable


def test_no_text_ships_that_its_owner_has_not_given_away() -> None:
    forms = [each for each in map(read_kind, SHIPPED.glob("*.toml")) if each.form]
    with_text = {each.name for each in forms if not each.why_unusable}
    assert with_text == {"SUS", "NASA-TLX", "effort", "fatigue", "pain-now"}
    assert all(each.source and each.licence for each in forms)
    assert not any("borg" in each.name.lower() for each in forms)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("items = [1, 4]", "items = [1, 5]", "The score part has items from 1 to 4."),
        ("items = [1, 4]", "items = [1, 1]", "names an item twice"),
        ("at_least = 3", "at_least = 5", "at_least is 1 to 4"),
        ('"participant"', '"therapist"', "A form is filled in by the participant"),
        ('"E", "F"', '"E"', "The words in de have another number of items than the form, 4."),
        ('["no", "yes"]', '["no", "so", "yes"]', "labels for both ends, for each point, or none"),
        ('name = "part"', 'name = "q1"', "Two fields are named 'q1'"),
        ("[form]\nitems = 4", "", "line 6: There is nothing named lowest here."),
        ('name = "mood"', 'name = "mood"\nbased_on = "x"', "No kind 'x' ships."),
        ("lowest = 1", "lowest = 0.5", "Lowest and highest of q1 are whole numbers, and points"),
        ("lowest = 1", "lowest = 0\nstep = 2", "Lowest and highest of q1 are whole numbers"),
        ("reversed = [4]", "reversed = [5]", "The form has reversed items from 1 to 4."),
        (FORM, MANY_LABELS, "labels for both ends, for each point, or none"),
        ('"H"]', '"H"]\nends = [["a\\u001b", "b"], [], [], []]', "The words in de"),
    ],
)
def test_a_form_that_cannot_be_used_is_refused_in_a_sentence(
    tmp_path: Path, old: str, new: str, says: str
) -> None:
    (tmp_path / "own.toml").write_text(FORM.replace(old, new), encoding="utf-8")
    with pytest.raises(KindError) as refused:
        read_kind(tmp_path / "own.toml")
    assert says in str(refused.value)


CHOICE = """
name = "hand"
title = "Hand"
entered_by = "participant"
[form]
[[fields]]
name = "hand"
title = "Which hand?"
type = "choice"
labels = ["left", "right"]
[words.de]
ends = [["links", "rechts"]]
"""


@pytest.mark.parametrize(
    ("labels", "says"),
    [
        ('"links"', "The choice hand has another number of labels in de."),
        ('"links", "rechts", "beide"', "The choice hand has another number of labels in de."),
        ('"links", "Links"', "The choice hand has two labels that are the same."),
        ('"links", "rechts "', "The choice hand has a label that is empty, or with blanks"),
    ],
)
def test_the_options_of_a_choice_are_the_same_in_each_language(
    tmp_path: Path, labels: str, says: str
) -> None:
    (tmp_path / "own.toml").write_text(CHOICE.replace('"links", "rechts"', labels), "utf-8")
    with pytest.raises(KindError) as refused:
        read_kind(tmp_path / "own.toml")
    assert says in str(refused.value)


def test_a_form_is_shown_in_the_language_that_it_has_words_in(own: Path) -> None:
    shown = [find("mood").language_shown(code) for code in ("de", "de-AT", "es", "en")]
    assert shown == ["de", "de", "en", "en"]


@pytest.mark.parametrize("rule", ["mean", "sum"])
def test_a_score_of_few_answers_lies_within_its_bounds(tmp_path: Path, rule: str) -> None:
    """A score that does not would make every correction of its record fail."""
    wide = FORM.replace("items = 4\nlowest = 1\nhighest = 7\nreversed = [4]\n", "")
    wide = wide[: wide.index("[[scores]]")]
    for name, highest in (("a", 10), ("b", 100)):
        wide += f'[[fields]]\nname = "{name}"\ntitle = "{name}"\ntype = "integer"\n'
        wide += f"lowest = 0\nhighest = {highest}\n"
    wide += f'[[scores]]\nrule = "{rule}"\nmissing = "others"\n'
    (tmp_path / "own.toml").write_text(wide, encoding="utf-8")
    kind = read_kind(tmp_path / "own.toml")
    found = kind.read({"b": 100})
    assert kind.read(found) == found


def test_an_answer_that_is_no_number_is_missing() -> None:
    sus = find("SUS")
    assert compute(sus.scores[0], sus.items, {"q1": NOT_SAID}).missing == 10
