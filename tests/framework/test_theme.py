"""Given a theme's folder, when it is loaded, then it is whole, legible and never at odds with itself."""

import itertools
import json
import re
import shutil
import tomllib
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.theme import FACES, QUALITATIVE, SITUATIONS, Theme, contrast, holds_number
from sar_tui.plugins import Catalogue, PluginError, load_theme

SHIPPED = ("calm", "high-contrast")
GROUNDS = ("background", "surface")
WRITING = ("text", "muted", "accent", "positive", "neutral", "negative")


@pytest.fixture(params=SHIPPED)
def theme(request: pytest.FixtureRequest, catalogue: Catalogue) -> Theme:
    return catalogue.theme(request.param)


@pytest.fixture
def copy(tmp_path: Path, catalogue: Catalogue) -> Path:
    """A theme of one's own, to be broken."""
    folder = tmp_path / "mine"
    shutil.copytree(catalogue.theme_folder("calm"), folder)
    return folder


def change(file: Path, pattern: str, by: str) -> None:
    text, count = re.subn(pattern, by, file.read_text(encoding="utf-8"), count=1, flags=re.MULTILINE | re.DOTALL)
    assert count == 1
    file.write_text(text, encoding="utf-8")


def reword(folder: Path, situation: str, *wordings: str) -> None:
    """Give a theme other wordings for a situation; none at all takes the situation away."""
    file = folder / "phrases.en.toml"
    phrases = tomllib.loads(file.read_text(encoding="utf-8"))
    phrases.pop(situation, None)
    if wordings:
        phrases[situation] = wordings
    lines = (f"{name} = {json.dumps(words, ensure_ascii=False)}" for name, words in phrases.items())
    file.write_text("\n".join(lines), encoding="utf-8")


def sentence(folder: Path) -> str:
    with pytest.raises(PluginError) as caught:
        load_theme(folder)
    return str(caught.value)


def wcag_ratio(one: str, other: str) -> float:
    """WCAG 2.2, by the letter."""

    def luminance(color: str) -> float:
        linear = []
        for hex_pair in re.findall("..", color.removeprefix("#")):
            share = int(hex_pair, 16) / 255
            linear.append(share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4)
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_the_shipped_themes_are_these(catalogue: Catalogue) -> None:
    assert set(SHIPPED) <= set(catalogue.theme_names())


def test_every_shipped_theme_is_whole(catalogue: Catalogue) -> None:
    for name in catalogue.theme_names():
        assert catalogue.theme(name).problems() == []


@pytest.mark.parametrize(("name", "ratio"), [("calm", 4.5), ("high-contrast", 7.0)])
def test_every_text_colour_stands_out(catalogue: Catalogue, name: str, ratio: float) -> None:
    colors = catalogue.theme(name).colors
    for text, ground in itertools.product(WRITING, GROUNDS):
        assert wcag_ratio(getattr(colors, text), getattr(colors, ground)) >= ratio, (text, ground)


def test_success_and_failure_are_told_by_more_than_red_and_green(theme: Theme) -> None:
    assert theme.faces["happy"] != theme.faces["encouraging"] != theme.faces["neutral"]
    assert not set(theme.phrases["positive"]) & set(theme.phrases["negative"])


def test_the_faces_are_all_of_one_size_so_that_nothing_jumps(theme: Theme) -> None:
    sizes = {(len(face.splitlines()), max(map(len, face.splitlines()))) for face in theme.faces.values()}
    assert set(FACES) <= set(theme.faces)
    assert len(sizes) == 1


@pytest.mark.parametrize(
    ("one", "other", "ratio"),
    [("#000000", "#ffffff", 21.0), ("#777777", "#ffffff", 4.48), ("#123456", "#123456", 1.0)],
)
def test_contrast_is_that_of_wcag(one: str, other: str, ratio: float) -> None:
    assert contrast(one, other) == pytest.approx(ratio, abs=0.01)
    assert contrast(other, one) == contrast(one, other)


@given(st.from_regex("#[0-9a-f]{6}", fullmatch=True), st.from_regex("#[0-9a-f]{6}", fullmatch=True))
def test_contrast_agrees_with_the_definition(one: str, other: str) -> None:
    assert contrast(one, other) == pytest.approx(wcag_ratio(one, other))


@pytest.mark.parametrize("text", ["32 ms", "Two more.", "One-handed", "a hundred", "TWICE as good", "٣ times", "x2"])
def test_numbers_are_found_in_digits_and_words(text: str) -> None:
    assert holds_number(text)


@pytest.mark.parametrize("text", ["Everyone is often at tension.", "Well done.", "Attend to the phone", ""])
def test_a_number_word_inside_another_word_is_none(text: str) -> None:
    assert not holds_number(text)


def test_a_missing_situation_is_named(copy: Path) -> None:
    reword(copy, "goodbye")
    assert sentence(copy) == "The theme mine cannot be used: There is no wording for goodbye."


def test_an_empty_situation_is_named(copy: Path) -> None:
    change(copy / "phrases.en.toml", r"^goodbye = \[.*?\n\]\n", "goodbye = []\n")
    assert sentence(copy) == "The theme mine cannot be used: There is no wording for goodbye."


def test_an_unknown_situation_is_named(copy: Path) -> None:
    reword(copy, "farewell", "Bye.")
    assert sentence(copy) == "The theme mine cannot be used: farewell is not a situation."


def test_a_missing_face_is_named(copy: Path) -> None:
    change(copy / "theme.toml", r"^sleeping = '''.*?'''", "")
    assert sentence(copy) == "The theme mine cannot be used: There is no face for sleeping."


@pytest.mark.parametrize("value", ["red", "#12345", "#12345g", "112233"])
def test_a_colour_that_is_none_is_named(copy: Path, value: str) -> None:
    change(copy / "theme.toml", r'^accent = "[^"]*"', f'accent = "{value}"')
    assert sentence(copy) == f"The theme mine cannot be used: accent is not a colour like #a0b1c2: {value}."


def test_a_colour_too_faint_is_named_with_its_contrast(copy: Path) -> None:
    change(copy / "theme.toml", r'^muted = "[^"]*"', 'muted = "#444444"')
    assert re.search(r"muted on background has a contrast of 1\.\d, less than 4\.5\.", sentence(copy))


@pytest.mark.parametrize("colour", ["accent", "background"])
def test_a_missing_colour_is_named(copy: Path, colour: str) -> None:
    change(copy / "theme.toml", rf'^{colour} = "[^"]*"\n', "")
    assert f"missing required field `{colour}`" in sentence(copy)


def test_an_unknown_colour_or_setting_is_named(copy: Path) -> None:
    change(copy / "theme.toml", r"^dark = true", "dark = true\nloud = true")
    assert "loud" in sentence(copy)


@pytest.mark.parametrize(
    ("situation", "wording", "problem"),
    [
        ("goodbye", "Bye, {name}.", "A wording for goodbye uses the slot name, which it does not have."),
        (
            "positive_first",
            "{value}, {difference}",
            "A wording for positive_first uses the slot difference, which it does not have.",
        ),
        ("neutral", "Three quarters there.", "A wording for neutral holds a number: 'Three quarters there.'."),
        ("accuracy", "Get 8 right.", "A wording for accuracy holds a number: 'Get 8 right.'."),
        ("negative_same", "The same as before.", "A wording for negative_same gives no figure: 'The same"),
        ("positive_improved", "You were {change}.", "A wording for positive_improved gives no figure: 'You"),
        ("neutral_first", "At {value", "A wording for neutral_first has broken slots (expected '}' before end"),
        ("neutral_first", "At {value:.1f}", "A wording for neutral_first has broken slots (Unknown format code 'f'"),
        ("neutral_first", "At {value!x}", "A wording for neutral_first has broken slots (Unknown conversion specifier"),
        ("neutral_first", "At {value:{width}}", "A wording for neutral_first has broken slots ('width')"),
        ("neutral_first", "At {}", "A wording for neutral_first uses the slot"),
        ("neutral_first", "At {value.real}", "A wording for neutral_first uses the slot value.real, which it does not"),
    ],
)  # fmt: skip
def test_a_wording_that_cannot_be_is_told_in_one_sentence(
    copy: Path, situation: str, wording: str, problem: str
) -> None:
    reword(copy, situation, wording)
    assert sentence(copy).startswith(f"The theme mine cannot be used: {problem}")


def test_every_problem_is_told_and_not_only_the_first(copy: Path) -> None:
    reword(copy, "goodbye")
    reword(copy, "neutral", "Half way.")
    assert "There is no wording for goodbye." in sentence(copy)
    assert "A wording for neutral holds a number" in sentence(copy)


@pytest.mark.parametrize("file", ["theme.toml", "phrases.en.toml"])
def test_broken_toml_a_missing_file_and_a_wrong_type_are_told(copy: Path, file: str) -> None:
    kept = (copy / file).read_text(encoding="utf-8")
    for broken in ("title = ", "[colors]\ntitle = 3\n", "positive = 3\n", kept + "\n[faces]\n"):
        (copy / file).write_text(broken, encoding="utf-8")
        assert sentence(copy).startswith("The theme mine cannot be read: ")
    (copy / file).write_bytes(b"\xff\xfe")
    assert sentence(copy).startswith("The theme mine cannot be read: ")
    (copy / file).unlink()
    assert sentence(copy).startswith("The theme mine cannot be read: ")


@given(st.text(max_size=60), st.sampled_from(sorted(SITUATIONS)))
def test_a_wording_without_problems_can_be_said(copy: Path, wording: str, situation: str) -> None:
    theme = load_theme(copy)
    reworded = msgspec.structs.replace(theme, phrases={**theme.phrases, situation: (wording,)})
    if not reworded.problems():
        said = wording.format(**dict.fromkeys(SITUATIONS[situation], "12 ms"))
        assert situation not in QUALITATIVE or not holds_number(said)


@given(st.lists(st.sampled_from(["{", "}", "{{", "}}", "value", "goal", "!", ":", "r", "12", "[0]", ".x", " "])))
def test_whatever_is_done_with_braces_a_wording_is_refused_or_can_be_said(copy: Path, parts: list[str]) -> None:
    wording = "".join(parts)
    theme = load_theme(copy)
    reworded = msgspec.structs.replace(theme, phrases={**theme.phrases, "neutral_first": (wording,)})
    if not reworded.problems():
        assert wording.format(value="12 ms", goal="12 ms")
