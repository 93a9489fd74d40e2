"""A theme's folder with any fault still gives a whole agent, and the fault is reported."""

import json
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from sar_tui.loop.phrase_keys import PHRASE_KEYS, VOCABULARY
from sar_tui.model.gesture import GESTURES
from sar_tui.model.theme import FACES, MANNERS, Manner, Theme, ThemeError, Voice
from sar_tui.plugins import Catalogue, PluginError, load_theme
from sar_tui.theme_folder import files, languages, may_have_images, read, read_theme
from sar_tui.theme_folder.appearance import drawing_problems, fitted
from tests.edit import edit
from tests.examples import examples

Change = Callable[[str, str, str], None]


@pytest.fixture
def mine(tmp_path: Path, catalogue: Catalogue) -> Path:
    """A copy of the playful theme, to be broken."""
    folder = tmp_path / "mine"
    shutil.copytree(catalogue.theme_folder("playful"), folder)
    return folder


@pytest.fixture
def change(mine: Path) -> Change:
    """``change("theme.toml", old, new)`` breaks the copy."""

    return lambda name, old, new: edit(mine / name, old, new)


def write(file: Path, text: str) -> None:
    file.write_text(text, encoding="utf-8")


def without(folder: Path, situation: str, language: str) -> None:
    """Take a situation out of the phrases of a language."""
    file = folder / f"phrases.{language}.toml"
    text = file.read_text(encoding="utf-8")
    before, rest = text.split(f"\n{situation} = [", 1)
    write(file, before + rest.split("\n]", 1)[1])


def as_toml(value: object) -> str:
    """A value as TOML writes it on a line."""
    match value:
        case dict():
            return f"{{{', '.join(f'{as_toml(key)} = {as_toml(inner)}' for key, inner in value.items())}}}"
        case list():
            return f"[{', '.join(map(as_toml, value))}]"
        case float():
            return repr(value)
    return json.dumps(value, ensure_ascii=False)


def applied(folder: Path, language: str = "en") -> Theme:
    """Return the theme as a session uses it: completed from calm."""
    theme = load_theme(folder, language)
    assert all(theme.phrases[situation] for situation in PHRASE_KEYS)
    assert all(theme.faces[face] for face in FACES)
    assert all(not theme.gestures[gesture].problems(gesture) for gesture in GESTURES)
    assert all(theme.vocabulary[name] for name in VOCABULARY)
    return theme


def test_a_complete_theme_needs_no_repair(mine: Path) -> None:
    theme = applied(mine)
    assert (theme.repairs, theme.name, theme.title) == ((), "mine", "Playful")
    assert (theme.language, theme.languages) == ("en", ("en", "de", "es"))
    names = {path.name for path in files(mine)}
    assert names >= {"phrases.en.toml", "phrases.es.toml", "theme.toml"}


@pytest.mark.parametrize(
    ("value", "repair"),
    [
        ("", "There is no wording for goodbye (en)."),
        ('goodbye = "Hello!"', "The wordings for goodbye (en) must be a list of texts."),
        ("goodbye = [1, 2]", "The wordings for goodbye (en) must be a list of texts."),
    ],
)
def test_wordings_that_are_missing_or_no_texts_are_from_the_default_theme(
    mine: Path, calm: Theme, value: str, repair: str
) -> None:
    without(mine, "goodbye", "en")
    file = mine / "phrases.en.toml"
    write(file, f"{value}\n" + file.read_text(encoding="utf-8"))
    theme = applied(mine)
    assert theme.phrases["goodbye"] == calm.phrases["goodbye"]
    assert theme.repairs[0] == repair


def test_a_phrase_missing_in_spanish_is_from_english(mine: Path, catalogue: Catalogue) -> None:
    without(mine, "rest", "es")
    theme = applied(mine, "es")
    assert theme.phrases["rest"] == catalogue.theme("playful").phrases["rest"]
    assert theme.phrases["greeting"] == catalogue.theme("playful", "es").phrases["greeting"]
    assert theme.repairs == ("There is no wording for rest (es); English is used.",)
    assert read(mine, "es").english == ("rest",)
    assert applied(mine, "en").repairs == ()
    without(mine, "rest", "en")
    assert applied(mine, "es").phrases["rest"] == catalogue.theme("calm", "es").phrases["rest"]


def test_an_english_substitute_is_checked_for_english_numbers(mine: Path, change: Change) -> None:
    without(mine, "goodbye", "es")
    change("phrases.en.toml", "We are done! I liked", "Par for the course! I liked")
    assert any("Par for" in wording for wording in applied(mine, "es").phrases["goodbye"])


def test_an_invalid_wording_or_phrase_key_is_left_out(mine: Path, change: Change) -> None:
    change("phrases.en.toml", '"Hi there! Let us play together."', '"Hi {name}!", "We play twice."')
    change("phrases.en.toml", "\ngoodbye = [", "\nfarewell = ['Bye.']\ngoodbye = [")
    theme = applied(mine)
    assert len(theme.phrases["greeting"]) == 2
    assert set(theme.repairs) == {
        "A wording for greeting (en) uses the unknown slot {name}.",
        "A wording for greeting (en) holds a number: 'We play twice.'.",
        "farewell is not a situation (en).",
    }


def test_vocabulary_falls_back_too(mine: Path, change: Change, calm: Theme) -> None:
    change("phrases.es.toml", 'goal = "la meta"\n', "")
    change("phrases.es.toml", "tu promedio de hoy", "tu media de hoy")
    spanish = applied(mine, "es")
    assert spanish.vocabulary["goal"] == "the goal"
    assert spanish.vocabulary["session_mean"] == applied(mine).vocabulary["session_mean"]
    assert set(spanish.repairs) == {
        "The vocabulary lacks goal (es).",
        "session_mean in vocabulary (es) holds a number.",
    }
    change("phrases.en.toml", 'goal = "the goal"', 'goal = " "\nrecord = "the record"\nlast = 3')
    theme = applied(mine)
    assert theme.vocabulary["goal"] == calm.vocabulary["goal"]
    assert theme.repairs == (
        "goal in vocabulary (en) must be a text.",
        "last in vocabulary (en) must be a text.",
        "record is not a word of the vocabulary (en).",
    )


_ONE_OR_TWO = "kg in units (en) must be one text, or two: singular | plural."


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ('" " = "things"', "A unit in units (en) has an empty name."),
        ('kg = "a | b | c"', _ONE_OR_TWO),
        ('kg = "kilogram |"', _ONE_OR_TWO),
    ],
)
def test_an_unspeakable_unit_is_left_out(
    mine: Path, change: Change, unit: str, expected: str
) -> None:
    change("phrases.en.toml", "[units]\n", f"[units]\n{unit}\n")
    theme = applied(mine)
    assert theme.repairs == (expected,)
    assert theme.spoken("412 ms, and 3 more; 2 kg") == "412 milliseconds, and 3 more; 2 kg"


def test_a_vocabulary_that_is_not_a_table_is_reported(mine: Path, change: Change) -> None:
    change("phrases.en.toml", "[units]\n", "[other]\n")
    change("phrases.en.toml", "\ngoodbye = [", "\nunits = 'none'\ngoodbye = [")
    theme = applied(mine)
    assert theme.units["ms"] == "millisecond | milliseconds"
    assert set(theme.repairs) == {"units (en) must be a table.", "other is not a situation (en)."}


def test_a_regional_language_falls_back_to_its_base_language_and_others_to_english(
    mine: Path,
) -> None:
    assert applied(mine, "es-mx").phrases == applied(mine, "es").phrases
    assert applied(mine, "es-mx").language == "es-mx"
    assert applied(mine, "en-gb").repairs == ()
    write(mine / "phrases.es-mx.toml", 'greeting = ["¡Qué onda!"]')
    assert applied(mine, "es-mx").phrases["greeting"] == ("¡Qué onda!",)
    assert languages(mine) == ("en", "de", "es", "es-mx")
    french = applied(mine, "fr")
    assert (french.language, french.phrases) == ("en", applied(mine).phrases)
    assert french.repairs == ("There is no phrases.fr.toml; the agent speaks English.",)


def test_a_theme_without_english_is_reported_and_completed(mine: Path) -> None:
    (mine / "phrases.en.toml").unlink()
    theme = applied(mine, "es")
    assert theme.language == "es"
    assert theme.repairs == ("There is no phrases.en.toml, which every theme has.",)
    with pytest.raises(PluginError, match=r"cannot be read: There is no phrases\.en\.toml\.$"):
        load_theme(mine)


def test_a_theme_may_replace_screen_texts_that_keep_their_slots(mine: Path) -> None:
    write(mine / "words.es.toml", '"Press Enter" = "Pulsa Intro"\nodd = 3\n')
    write(mine / "words.es-mx.toml", '"Press Enter" = "Oprime Enter"\n')
    assert applied(mine, "es").texts == {"Press Enter": "Pulsa Intro"}
    assert applied(mine, "es-mx").texts == {"Press Enter": "Oprime Enter"}
    assert applied(mine).texts == {}
    assert applied(mine, "es").repairs == ("The wording of 'odd' in words.es.toml is not a text.",)
    write(mine / "words.en.toml", '"level {level}" = "step {step}"\n"Help" = "What is this?"\n')
    assert applied(mine).texts == {"Help": "What is this?"}
    (said,) = applied(mine).repairs
    assert said == "The wording of 'level {level}' in words.en.toml lacks {level}."


@pytest.mark.parametrize("value", ['"#12345"', "3"])
def test_an_invalid_colour_is_replaced_legibly(mine: Path, change: Change, value: str) -> None:
    change("theme.toml", 'accent = "#a33b00"', f"accent = {value}")
    theme = applied(mine)
    assert theme.repairs[0].startswith("accent is not a colour like #a0b1c2: ")
    assert min(theme.colors.contrasts().values()) >= 4.5


def test_missing_and_unknown_colours_and_faces_are_reported(
    mine: Path, change: Change, calm: Theme
) -> None:
    change("theme.toml", "background = ", "backdrop = ")
    change("theme.toml", "sleeping = '''", "asleep = '''")
    theme = applied(mine)
    assert theme.colors.background == calm.colors.background
    assert theme.faces["sleeping"] == calm.faces["sleeping"]
    assert "background is not a colour like #a0b1c2: nothing." in theme.repairs
    assert "There is no face for sleeping." in theme.repairs
    for unknown in (
        "backdrop is not a colour of a theme; these are: background",
        "asleep is not an expression; these are: neutral, listening",
    ):
        assert any(said.startswith(unknown) for said in theme.repairs)


@given(st.lists(st.integers(0, 0xFFFFFF), min_size=8, max_size=8))
@examples(30)
def test_text_has_enough_contrast_in_any_case(mine: Path, calm: Theme, values: list[int]) -> None:
    names = msgspec.structs.asdict(calm.colors)
    colors = {name: f"#{value:06x}" for name, value in zip(names, values, strict=True)}
    colors["surface"] = colors["background"]
    (mine / "theme.toml").write_text(f"colors = {as_toml(colors)}", encoding="utf-8")
    assert min(applied(mine).colors.contrasts().values()) >= 4.5


def test_an_unfit_face_is_replaced(mine: Path, change: Change, calm: Theme) -> None:
    change(
        "theme.toml", f"sleeping = '''\n{applied(mine).faces['sleeping']}", "sleeping = '''\n(o_o)"
    )
    theme = applied(mine)
    assert theme.faces["sleeping"] == calm.faces["sleeping"]
    assert "face sleeping" in theme.repairs[0]


def test_faces_of_different_height_are_reported(mine: Path, change: Change) -> None:
    change("theme.toml", "│  = ‿ =  │\n ╰───────╯ \n", "│  = ‿ =  │\n")
    (said,) = applied(mine).repairs
    assert said == "The faces have 3 and 4 lines; all must have the same number."
    assert {face.count("\n") for face in applied(mine).faces.values()} == {3}


@pytest.mark.parametrize(
    ("old", "new", "repair"),
    [
        ("nod = 0.9", "nod = 1.9", "In nod at 200 ms nod is 1.9; it must be between -1 and 1."),
        ("nod = 0.9", "nod = nan", "In nod at 200 ms nod is nan; it must be between -1 and 1."),
        ("nod = 0.9", "tail = 0.9", "gestures.nod in theme.toml cannot be used: Object contains unknown field `tail`"),
        ("{ at_ms = 1000 }", "{ at_ms = 1000, turn = 0.5 }", "The gesture nod must end at rest"),
        ("{ at_ms = 1000 }", "{ at_ms = 20000 }", "The gesture nod takes 20000 ms; at most 10000 are allowed."),
        ("at_ms = 450", "at_ms = 150", "The keyframes of nod must be in order of time, none before 0 ms."),
        ("nod = [\n", "nod = 'yes'\nbow = [\n", "gestures.nod in theme.toml cannot be used: Expected `array`"),
        ("nod = [\n", "nod = []\nbow = [\n", "The gesture nod has no keyframes."),
        ("nod = [\n", "bow = [\n", "There is no gesture nod."),
    ],
)  # fmt: skip
def test_an_invalid_gesture_is_replaced(
    mine: Path, change: Change, calm: Theme, old: str, new: str, repair: str
) -> None:
    change("theme.toml", old, new)
    theme = applied(mine)
    assert theme.gestures["nod"] == calm.gestures["nod"]
    assert theme.repairs
    assert all(said.startswith(repair) for said in theme.repairs)


def test_a_theme_may_define_gestures(mine: Path, change: Change) -> None:
    bow = "bow = [{ at_ms = 300, nod = 1 }, { at_ms = 600 }]"
    change("theme.toml", "[gestures]\n", f"[gestures]\n{bow}\n")
    goodbye = '[manner.goodbye]\ngesture = "bow"\n'
    change("theme.toml", "[manner.positive]\n", f"{goodbye}[manner.positive]\n")
    theme = applied(mine)
    assert theme.manner("goodbye") == Manner("happy", "bow")
    assert theme.repairs == ()


@pytest.mark.parametrize(
    ("manner", "repair"),
    [
        ('gesture = "jump"', "The manner of positive has the gesture jump, which does not exist."),
        ('face = "angry"', "The manner of positive has the face angry, which does not exist."),
        ('gaze = "away"', "The manner of positive has the gaze away, which does not exist."),
        ('tone = "boo"', "The manner of positive has the tone boo, which does not exist."),
        ('smell = "nice"', "manner.positive in theme.toml cannot be used: Object contains unknown"),
    ],
)
def test_an_unknown_manner_falls_back(mine: Path, change: Change, manner: str, repair: str) -> None:
    change("theme.toml", '[manner.positive]\ngesture = "cheer"', f"[manner.positive]\n{manner}")
    theme = applied(mine)
    assert theme.manner("positive") == MANNERS["positive"]
    (said,) = theme.repairs
    assert said.startswith(repair)


@pytest.mark.parametrize(
    ("old", "new", "repair"),
    [
        ("[manner.positive]", "[manner.triumph]", "triumph has no manner; these have: greeting"),
        ("[voice]\nrate = 160", "[voice]\nrate = 20", "voice in theme.toml cannot be used: Expected `int` >= 80"),
        ("hz = 784, ms = 80", "hz = 784, ms = 80000", "tones.go in theme.toml cannot be used: Expected `int` <= 1000"),
        ("go = [{ hz = 784, ms = 80 }, { hz = 1047, ms = 120 }]", "go = []", "tones.go in theme.toml cannot be used"),
        ("\ngo = [", "\nboo = [", "boo is not a tone; these are: go, success, end."),
        ("dark = false", "dark = 'no'", "dark in theme.toml cannot be used: Expected `bool`"),
        ("dark = false", "dark = false\nloud = true", "theme.toml has no use for loud."),
        ("dark = false\n", "", "theme.toml does not say its dark."),
        ("minimum_contrast = 4.5", "minimum_contrast = nan", "minimum_contrast in theme.toml cannot be used"),
        ("minimum_contrast = 4.5", "minimum_contrast = 22", "minimum_contrast in theme.toml cannot be used"),
        ("title = ", "label = ", "theme.toml has no use for label."),
        ("mouth_line = 2", "mouth_line = 'two'", "mouth_line in theme.toml cannot be used: Expected `int`"),
    ],
)  # fmt: skip
def test_other_faults_are_reported_and_harmless(
    mine: Path, change: Change, old: str, new: str, repair: str
) -> None:
    change("theme.toml", old, new)
    theme = applied(mine)
    assert theme.repairs[0].startswith(repair)
    assert theme.notes("go")
    assert theme.title


def test_a_value_in_place_of_a_table_is_reported(mine: Path, calm: Theme) -> None:
    tables = ("colors", "faces", "gestures", "manner", "tones", "images")
    write(mine / "theme.toml", "voice = 3\n" + "".join(f"{table} = 3\n" for table in tables))
    theme = applied(mine)
    assert (theme.colors, theme.faces, theme.gestures) == (calm.colors, calm.faces, calm.gestures)
    assert theme.voice == Voice()
    said = {f"{table} in theme.toml must be a table." for table in tables}
    said.add("voice in theme.toml cannot be used: Expected `object`, got `int`.")
    assert said < set(theme.repairs)


def test_images_must_be_in_the_themes_folder(mine: Path, change: Change) -> None:
    assert not may_have_images(mine)
    for image in (mine / "happy.png", mine.parent / "outside.png"):
        image.write_bytes(b"\x89PNG")
    (mine / "loop.png").symlink_to(mine / "loop.png")
    images = """happy = "happy.png"
neutral = "none.png"
speaking = "../outside.png"
angry = "happy.png"
sleeping = 3
listening = "loop.png"
"""
    change("theme.toml", "[tones]", f"[images]\n{images}[tones]")
    theme = applied(mine)
    assert theme.images == {"happy": "happy.png"}
    assert set(theme.repairs) == {
        "There is no image none.png for neutral.",
        "The image ../outside.png for speaking must be in the theme's folder.",
        f"images.angry is not an expression; these are: {', '.join(FACES)}.",
        "There is no image 3 for sleeping.",
        "There is no image loop.png for listening.",
    }
    assert may_have_images(mine), "seen without reading the theme"
    (mine / "theme.toml").unlink()
    assert not may_have_images(mine)


@pytest.mark.parametrize("name", ["a\\u0000b.png", "a" * 300 + ".png", "a/" * 3000])
def test_an_impossible_image_name_is_told_briefly(mine: Path, change: Change, name: str) -> None:
    change("theme.toml", "[tones]", f'[images]\nhappy = "{name}"\n[tones]')
    theme = applied(mine)
    assert theme.images == {}
    (expected,) = theme.repairs
    assert expected.startswith("There is no image a")
    assert expected.isprintable()
    assert len(expected) < 100


@pytest.mark.parametrize("fault", [OSError("gone"), ValueError("odd"), OverflowError("large")])
def test_any_error_reading_a_theme_is_one_sentence(
    mine: Path, monkeypatch: pytest.MonkeyPatch, fault: Exception
) -> None:
    monkeypatch.setattr("sar_tui.theme_folder.read_look", Mock(side_effect=fault))
    said = rf"^The theme mine cannot be read: {type(fault).__name__}: {fault}\.$"
    with pytest.raises(PluginError, match=said):
        load_theme(mine)


@pytest.mark.parametrize("asked", ["4.49", "-inf", "-1" + "0" * 400])
def test_a_text_colour_of_low_contrast_is_replaced_whatever_a_theme_requires(
    mine: Path, change: Change, asked: str
) -> None:
    change("theme.toml", 'muted = "#6b5138"', 'muted = "#d0c0a0"')
    change("theme.toml", "minimum_contrast = 4.5", f"minimum_contrast = {asked}")
    theme = applied(mine)
    assert theme.minimum_contrast == 4.5
    assert theme.colors.muted == "#000000"
    required, *low = theme.repairs
    assert required.startswith(f"minimum_contrast is {asked[:3]}")
    assert required.endswith("; it must be at least 4.5, below which text is hard to read.")
    assert low == [
        "muted on background has a contrast of 1.63, less than 4.5.",
        "muted on surface has a contrast of 1.49, less than 4.5.",
    ]


def test_a_theme_needs_no_wordings_of_its_own_before_a_new_level(mine: Path) -> None:
    without(mine, "encouragement_new_level", "es")
    theme = read_theme(mine, "es")
    assert theme.repairs == ()
    assert theme.phrases["encouragement_new_level"] == theme.phrases["encouragement"]


def test_an_empty_theme_equals_the_default_under_its_own_name(tmp_path: Path, calm: Theme) -> None:
    folder = tmp_path / "bare"
    folder.mkdir()
    with pytest.raises(ThemeError, match=r"^There is no theme\.toml\.$"):
        read_theme(folder)
    for name in ("theme.toml", "phrases.en.toml"):
        (folder / name).touch()
    theme = applied(folder)
    assert (theme.name, theme.title) == ("bare", "bare")
    assert (theme.phrases, theme.faces) == (calm.phrases, calm.faces)
    assert len(theme.repairs) > len(PHRASE_KEYS)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("theme.toml", b'title = "Mine"\ngreeting = [\n', r"theme\.toml is not TOML"),
        ("theme.toml", b"a = " + b"[" * 5000, r"theme\.toml is not TOML"),
        ("phrases.es.toml", b"greeting = [\n", r"phrases\.es\.toml is not TOML"),
        (
            "phrases.es.toml",
            b"a = [\n'\xa1Hola!']\n",
            r"phrases\.es\.toml is not UTF-8 text from line 2 on;",
        ),
        ("theme.toml", None, r"theme\.toml cannot be read: Is a directory\.$"),
    ],
    ids=["a list without end", "nested too deeply", "phrases", "another encoding", "a folder"],
)
def test_an_unreadable_file_is_reported(
    mine: Path, name: str, content: bytes | None, said: str
) -> None:
    if content is None:
        (mine / name).unlink()
        (mine / name).mkdir()
    else:
        (mine / name).write_bytes(content)
    with pytest.raises(PluginError, match=rf"^The theme mine cannot be read: {said}"):
        load_theme(mine, "es")
    if name.startswith("phrases"):
        assert applied(mine, "en").repairs == (), "its other language can be used"


def test_what_an_editor_adds_or_strips_changes_nothing(mine: Path) -> None:
    whole = applied(mine).faces
    for file in files(mine):
        lines = file.read_text(encoding="utf-8").split("\n")
        stripped = "\r\n".join(map(str.rstrip, lines))
        file.write_bytes(b"\xef\xbb\xbf" + stripped.encode())
    assert (applied(mine).faces, applied(mine).repairs) == (whole, ())
    assert applied(mine, "es").repairs == ()


JUNK = st.recursive(
    st.booleans() | st.integers(-5, 5000) | st.floats() | st.text("aé1{} ", max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text("ab_", min_size=1), inner, max_size=3)
    ),
    max_leaves=5,
)


@given(data=st.data())
@examples(60)
def test_any_readable_theme_is_whole(mine: Path, catalogue: Catalogue, data: st.DataObject) -> None:
    for name in ("theme.toml", "phrases.en.toml"):
        table = tomllib.loads(
            (catalogue.theme_folder("playful") / name).read_text(encoding="utf-8")
        )
        for key in data.draw(st.lists(st.sampled_from(sorted(table)), max_size=3, unique=True)):
            inside = table[key]
            if isinstance(inside, dict) and data.draw(st.booleans()):
                inside[data.draw(st.sampled_from(sorted(inside)))] = data.draw(JUNK)
            else:
                table[key] = data.draw(JUNK)
        text = "".join(f"{as_toml(key)} = {as_toml(value)}\n" for key, value in table.items())
        (mine / name).write_text(text, encoding="utf-8")
    applied(mine)


# --- drawn faces


_LARGE = "is larger than 11 columns and 4 lines."
_ODD = "is drawn with what does not fill one column:"
CAT = " /\\_/\\ \n( o o )\n( = = )\n \\___/ "


@pytest.mark.parametrize(
    ("face", "problem"),
    [
        (f"{CAT}\nx", _LARGE),
        ("\n".join(["x" * 12] * 4), _LARGE),
        ("o o\n===", "has no line 2, counted from 0, for its mouth (mouth_line)."),
        ("o o\no o\n😀", rf"{_ODD} '\U0001f600'."),
        ("o o\no o\n中", rf"{_ODD} '\u4e2d'."),
        ("o o\no o\ne\u0301", rf"{_ODD} '\u0301'."),
        ("o o\no\to\n===", rf"{_ODD} '\t'."),
    ],
)
def test_a_face_that_does_not_fit_is_reported(face: str, problem: str) -> None:
    assert drawing_problems("happy", face, 2) == [f"The face happy {problem}"]


def test_faces_are_padded_to_one_size() -> None:
    assert fitted({"happy": "o o\n =", "sleeping": "- - z\n  -\n..."}) == {
        "happy": "o o  \n =   \n     ",
        "sleeping": "- - z\n  -  \n...  ",
    }
    assert fitted({}) == {}


@given(st.characters(exclude_characters="\n"))
def test_allowed_characters_fill_one_column(character: str) -> None:
    if not drawing_problems("happy", f".\n.\n.{character}", 2):
        assert cell_len(character) == 1
