"""``sar-tui themes``: list, create, check."""

import errno
import re
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from sar_tui.cli.scaffold import new_theme
from sar_tui.plugin_loader import user_folder
from sar_tui.plugins import Catalogue
from tests.edit import edit
from tests.program import Call

Change = Callable[[str, str, str], Path]


@pytest.fixture
def evening(tmp_path: Path) -> Path:
    """The folder of a new theme."""
    return new_theme("evening", tmp_path / "mine", "playful", Catalogue())


@pytest.fixture
def change(evening: Path) -> Change:
    """Return a function ``change("theme.toml", old, new)`` that edits the new theme and returns its
    folder.
    """

    def changed(file: str, old: str, new: str) -> Path:
        edit(evening / file, old, new)
        return evening

    return changed


@pytest.fixture
def own_themes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Folder of the user's own themes, empty at first."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setattr(
        "sar_tui.plugin_loader.user_folder", lambda: tmp_path / "config" / "sar-tui"
    )
    return tmp_path / "config" / "sar-tui" / "themes"


# --- listed


def test_themes_are_listed_with_title_languages_and_summary(call: Call) -> None:
    called = call("themes")
    assert called.code == 0
    for part in ("high-contrast", "High contrast", "en, es", "White and yellow on black"):
        assert part in called.out
    assert "!" not in called.out


def test_themes_json(call: Call) -> None:
    rows = call("themes --json").json["themes"]
    assert [row["name"] for row in rows] == ["calm", "high-contrast", "playful"]
    assert rows[0] == {
        "name": "calm",
        "title": "Calm",
        "languages": ["en", "es"],
        "summary": "Quiet colours and an even voice, for adults.",
        "repairs": [],
    }


def test_an_incomplete_theme_is_listed_with_what_to_do(
    call: Call, own_themes: Path, change: Change
) -> None:
    shutil.copytree(change("theme.toml", "sleeping = '''", "asleep = '''"), own_themes / "evening")
    assert (
        "! evening has problems, so replacements are used: sar-tui themes check evening"
        in call("themes").out
    )
    row = next(row for row in call("themes --json").json["themes"] if row["name"] == "evening")
    assert "There is no face for sleeping." in row["repairs"]


def test_a_theme_that_cannot_be_read_is_listed_with_its_reason(
    call: Call, own_themes: Path, evening: Path
) -> None:
    (evening / "phrases.en.toml").unlink()
    shutil.copytree(evening, own_themes / "evening")
    called = call("themes")
    assert called.code == 0
    assert "✗ The theme evening cannot be read: There is no phrases.en.toml." in called.out
    assert "calm" in called.out
    assert set(call("themes --json").json["themes"][-1]) == {"name", "error"}


# --- created


@pytest.mark.parametrize("model", ["calm", "high-contrast", "playful"])
def test_a_new_theme_passes_its_check(call: Call, tmp_path: Path, model: str) -> None:
    called = call("themes new warm-light --from", model, "--to", tmp_path)
    assert called.code == 0
    assert f"Created {tmp_path / 'warm-light'}, a copy of {model}" in called.out
    checked = call("themes check", tmp_path / "warm-light")
    assert checked.code == 0
    assert "✗" not in checked.out
    assert (
        tomllib.loads((tmp_path / "warm-light" / "theme.toml").read_text(encoding="utf-8"))["title"]
        == "Warm light"
    )


def test_a_new_theme_keeps_the_comments_of_its_template(
    catalogue: Catalogue, evening: Path
) -> None:
    model = catalogue.theme_folder("playful")
    for file in model.iterdir():
        copy = (evening / file.name).read_text(encoding="utf-8")
        assert copy == file.read_text(encoding="utf-8").replace(
            'title = "Playful"', 'title = "Evening"'
        )
        assert "# " in copy


def test_a_new_theme_is_created_in_the_users_folder_by_default(
    call: Call, own_themes: Path
) -> None:
    called = call("themes new evening")
    assert called.code == 0
    assert "sar-tui themes check evening" in called.out
    assert call("themes check evening").code == 0
    assert "Evening" in call("themes").out
    assert Catalogue().theme("evening", "es").phrases == Catalogue().theme("calm", "es").phrases
    assert (own_themes / "evening" / "theme.toml").is_file()


def test_creating_a_theme_elsewhere_prints_how_to_use_it(call: Call, tmp_path: Path) -> None:
    called = call("themes new dusk --to", tmp_path)
    assert f"sar-tui themes check {tmp_path / 'dusk'}" in called.out
    assert f"To choose it in a session, move it to {user_folder() / 'themes'}." in called.out


def test_images_and_folders_of_the_template_are_copied_and_can_be_edited(
    call: Call, own_themes: Path, change: Change, tmp_path: Path
) -> None:
    model = change("theme.toml", "[tones]", '[images]\nhappy = "faces/happy.png"\n[tones]')
    (model / "faces").mkdir()
    (model / "faces" / "happy.png").write_bytes(b"\x89PNG")
    for file in model.glob("*.toml"):
        file.chmod(0o444)
    shutil.copytree(model, own_themes / "evening")
    assert call("themes new night --from evening --to", tmp_path).code == 0
    assert (tmp_path / "night" / "faces" / "happy.png").read_bytes() == b"\x89PNG"
    assert (tmp_path / "night" / "theme.toml").stat().st_mode & 0o200
    assert call("themes check", tmp_path / "night").code == 0


@pytest.mark.parametrize("name", ["Two words", "1st", "Evening", "../up", "a--b", "évening", ""])
def test_an_invalid_name_is_bad_input(call: Call, tmp_path: Path, name: str) -> None:
    called = call("themes new", name, "--to", tmp_path / "mine")
    assert called.code == 2
    assert "small letters" in called.err
    assert not (tmp_path / "mine").exists()


def test_an_existing_folder_is_never_overwritten(call: Call, evening: Path) -> None:
    (evening / "theme.toml").write_text("mine", encoding="utf-8")
    called = call("themes new evening --to", evening.parent)
    assert called.code == 2
    assert "exists already" in called.err
    assert (evening / "theme.toml").read_text(encoding="utf-8") == "mine"


def test_a_new_theme_that_does_not_fit_on_the_disk_leaves_nothing_behind(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        called = call("themes new evening --to", tmp_path)
    assert (called.code, called.err.startswith("The disk is full: ")) == (1, True)
    assert call("themes new evening --to", tmp_path).code == 0


def test_a_new_theme_does_not_replace_another(call: Call, tmp_path: Path) -> None:
    called = call("themes new calm --to", tmp_path)
    assert called.code == 2
    assert called.err == "There is a theme calm already. Choose another name.\n"
    assert not (tmp_path / "calm").exists()


def test_an_unknown_template_is_bad_input(call: Call, tmp_path: Path) -> None:
    called = call("themes new evening --from noon --to", tmp_path)
    assert called.code == 2
    assert called.err == "There is no theme noon. Choose one of: calm, high-contrast, playful.\n"


def test_an_unwritable_place_is_reported(call: Call, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    called = call("themes new evening --to", tmp_path / "file")
    assert called.code == 1
    assert "cannot be used: Not a directory." in called.err


# --- checked


@pytest.mark.parametrize("name", ["calm", "high-contrast", "playful"])
def test_the_bundled_themes_pass_their_check(call: Call, name: str) -> None:
    called = call("themes check", name)
    assert called.code == 0
    assert f"{name} passes all checks." in called.out
    assert "has every phrase in en" in called.out
    assert "has every phrase in es" in called.out


def test_contrast_is_measured_and_printed(call: Call) -> None:
    assert (
        "✓ has a contrast of at least 7 (text 21.00, muted 13.61, accent 16.12,"
        in call("themes check high-contrast").out
    )
    least = call("themes check playful --json").json["contrasts"]
    assert least[0] == {"color": "text", "ground": "surface", "ratio": 12.34}


def test_checks_as_json(call: Call, evening: Path) -> None:
    printed = call("themes check", evening, "--json").json
    assert (printed["theme"], printed["passed"], printed["languages"]) == (
        "evening",
        True,
        ["en", "es"],
    )
    assert printed["english"] == {}
    assert all(
        set(row) == {"check", "ok", "problems", "found"} and row["ok"] for row in printed["checks"]
    )
    assert {contrast["color"] for contrast in printed["contrasts"]} == {
        "text", "muted", "accent", "positive", "neutral", "negative",
    }  # fmt: skip


def test_phrases_that_fall_back_to_english_are_named(call: Call, change: Change) -> None:
    folder = change("phrases.es.toml", "\nrest = [", "\nbreak = [")
    called = call("themes check", folder)
    assert called.code == 1
    assert "✓ has every phrase in en" in called.out
    assert re.search(r"✗ has every phrase in es \(\d+ wordings\)", called.out)
    assert "    There is no wording for rest (es); English is used." in called.out
    printed = call("themes check", folder, "--json").json
    assert (printed["passed"], printed["english"]) == (False, {"es": ["rest"]})


@pytest.mark.parametrize(
    ("file", "old", "new", "says"),
    [
        ("theme.toml", 'title = "Evening"', "", "✗ has a title, a summary, and dark = true or false"),
        ("theme.toml", "dark = false", "dark = false\nloud = true", "    theme.toml has no use for loud."),
        ("theme.toml", "#6b5138", "#d0c0a0", "    muted on surface has a contrast of 1.49, less than 4.5."),
        ("theme.toml", "#6b5138", "brown", "    muted is not a colour like #a0b1c2: brown."),
        ("theme.toml", "[faces]\nneutral", "[faces]\nblank", "✗ has every expression, all of one size"),
        ("theme.toml", "shake = [", "shiver = [", "    There is no gesture shake."),
        ("theme.toml", "turn = -0.8", "turn = -8", "In shake at 200 ms turn is -8; it must be between -1 and 1."),
        ("theme.toml", 'gesture = "cheer"', 'gesture = "jump"', "✗ has a valid voice, manner and tones"),
        ("theme.toml", "rate = 160", "rate = 1600", "    voice in theme.toml cannot be used: Expected `int` <= 400"),
        ("theme.toml", "[faces]\n", "[faces\n", "✗ can be read\n    theme.toml is not TOML: "),
        ("phrases.es.toml", "greeting = [", "greeting = ", "✗ can be read\n    phrases.es.toml is not TOML: "),
        ("phrases.en.toml", "{value}! That reaches", "{valeu}! That reaches", "uses the unknown slot {valeu}."),
        ("phrases.es.toml", "¡Casi, casi!", "¡Casi once!", "holds a number: '¡Casi once! ¡Lo he visto!'."),
        ("phrases.en.toml", "goal = ", "gaol = ", "✗ has the vocabulary in en"),
        ("phrases.en.toml", "[units]", '[units]\n"" = "x"', "    A unit in units (en) has an empty name."),
        ("theme.toml", "minimum_contrast = 4.5", "minimum_contrast = 1", "    minimum_contrast is 1; it must be at"),
    ],
)  # fmt: skip
def test_each_breach_of_the_contract_is_named(
    call: Call, change: Change, file: str, old: str, new: str, says: str
) -> None:
    folder = change(file, old, new)
    called = call("themes check", folder)
    assert called.code == 1
    assert says in called.out
    assert "passes all checks" not in called.out


def test_screen_texts_of_a_theme_are_checked_in_every_language(call: Call, evening: Path) -> None:
    (evening / "words.es.toml").write_text(
        '"Press: {key}" = "¡Pulsa {key}!"\n"Help" = "¿Qué es esto?"\n', "utf-8"
    )
    called = call("themes check", evening)
    assert (called.code, "✓ has valid texts for the screens in es (2 texts)" in called.out) == (
        0,
        True,
    )
    (evening / "words.es.toml").write_text(
        '"level {level}" = "{nivel}"\n"Halp" = "Ayuda"\n"Quit" = 3', "utf-8"
    )
    (evening / "words.fr.toml").write_text('"Help = ', "utf-8")
    called = call("themes check", evening)
    assert called.code == 1
    for expected in (
        "✗ has valid texts for the screens in es (1 texts)",
        "    The wording of 'level {level}' in words.es.toml lacks {level}.",
        "    The wording of 'Quit' in words.es.toml is not a text.",
        "    No screen shows 'Halp', which words.es.toml translates.",
        "✗ has valid texts for the screens in fr\n    words.fr.toml is not TOML: ",
    ):
        assert expected in called.out


def test_each_language_is_checked_even_if_another_cannot_be_read(
    call: Call, change: Change
) -> None:
    folder = change("phrases.es.toml", "greeting = [", "greeting = ")
    assert "✓ has every phrase in en" in call("themes check", folder).out


def test_a_name_or_a_folder_may_be_checked(
    call: Call, evening: Path, own_themes: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(evening.parent)
    (evening.parent / "calm").mkdir()
    assert "calm passes all checks." in call("themes check calm").out
    assert "evening passes all checks." in call("themes check evening").out
    assert "evening passes all checks." in call("themes check", f"{evening}/").out


def test_a_folder_without_a_theme_fails_its_check(call: Call, tmp_path: Path) -> None:
    called = call("themes check", tmp_path)
    assert called.code == 1
    assert called.out == "✗ can be read\n    There is no theme.toml.\n"


def test_checking_an_unknown_theme_is_bad_input(call: Call) -> None:
    called = call("themes check noon")
    assert called.code == 2
    assert (
        called.err
        == "There is no theme or folder noon. Choose one of: calm, high-contrast, playful.\n"
    )


def test_slots_and_markup_are_printed_literally(call: Call, change: Change) -> None:
    folder = change("phrases.en.toml", '"You got there!"', '"[bold]Two {value}[/bold]"')
    out = call("themes check", folder).out
    assert "holds a number: '[bold]Two {value}[/bold]'." in out
