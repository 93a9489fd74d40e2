"""``sar-tui themes``: list, create, check."""

import errno
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from sar_tui.cli.scaffold import new_theme
from sar_tui.plugin_loader import user_folder
from sar_tui.plugins import Catalogue
from tests.edit import edit
from tests.examples import first
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
    monkeypatch.setattr("sar_tui.plugin_loader.user_folder", lambda: tmp_path / "config")
    return tmp_path / "config" / "themes"


# --- listed


def test_themes_are_listed_with_title_languages_and_summary(call: Call) -> None:
    called = call("themes")
    called.shows("high-contrast", "High contrast", "en, de, es", "White and yellow on black")
    assert "!" not in called.out
    rows = call("themes --json").json["themes"]
    assert [row["name"] for row in rows] == ["calm", "high-contrast", "playful"]
    assert set(rows[0]) == {"name", "title", "languages", "summary", "repairs"}
    assert (rows[0]["title"], rows[0]["languages"], rows[0]["repairs"]) == (
        "Calm",
        ["en", "de", "es"],
        [],
    )


def test_a_theme_that_is_incomplete_or_cannot_be_read_is_listed_with_what_to_do(
    call: Call, own_themes: Path, change: Change
) -> None:
    shutil.copytree(change("theme.toml", "sleeping = '''", "asleep = '''"), own_themes / "evening")
    call("themes").shows("! evening has problems", "sar-tui themes check evening")
    (row,) = (row for row in call("themes --json").json["themes"] if row["name"] == "evening")
    assert "There is no face for sleeping." in row["repairs"]
    (own_themes / "evening" / "phrases.en.toml").unlink()
    call("themes").shows("✗ The theme evening cannot be read: There is no phrases.en", "calm")
    assert set(call("themes --json").json["themes"][-1]) == {"name", "error"}


# --- created


@pytest.mark.parametrize("model", first(1, ["calm", "high-contrast", "playful"]))
def test_a_new_theme_is_a_copy_with_its_comments_and_passes_its_check(
    call: Call, catalogue: Catalogue, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, model: str
) -> None:
    def full(path: Path, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    new, folder = ("themes new warm-light --from", model, "--to", tmp_path), tmp_path / "warm-light"
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        call(*new).refused("The disk is full: ", code=1)
    call(*new).shows(f"Created {folder}, a copy of {model}", f"{user_folder() / 'themes'}.")
    checked = call("themes check", folder)
    assert (checked.code, "✗" in checked.out) == (0, False)
    for file in catalogue.theme_folder(model).iterdir():
        text = re.sub(
            '^title = ".*"', 'title = "Warm light"', file.read_text("utf-8"), flags=re.MULTILINE
        )
        assert (folder / file.name).read_text(encoding="utf-8") == text


def test_a_new_theme_is_created_in_the_users_folder_by_default(
    call: Call, own_themes: Path
) -> None:
    call("themes new evening").shows("sar-tui themes check evening")
    assert call("themes check evening").code == 0
    call("themes").shows("Evening")
    assert Catalogue().theme("evening", "es").phrases == Catalogue().theme("calm", "es").phrases
    assert (own_themes / "evening" / "theme.toml").is_file()


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
    call("themes new", name, "--to", tmp_path / "mine").refused("small letters")
    if name.isascii():  # a task has a name in Python
        call("tasks new", name, "--to", tmp_path / "mine").refused("small letters")
    assert not (tmp_path / "mine").exists()


def test_an_existing_folder_is_never_overwritten(call: Call, evening: Path) -> None:
    (evening / "theme.toml").write_text("mine", encoding="utf-8")
    for kind in ("tasks", "themes"):
        call(kind, "new", "evening", "--to", evening.parent).refused("exists already")
    assert (evening / "theme.toml").read_text(encoding="utf-8") == "mine"
    call("themes new night --to", evening / "theme.toml").refused("cannot be used", code=1)


# --- checked


@pytest.mark.slow
def test_the_bundled_themes_pass_their_check_and_contrast_is_measured(call: Call) -> None:
    for name in ("calm", "high-contrast", "playful"):
        called = call("themes check", name)
        called.shows(f"{name} passes all checks.", "every phrase in en", "every phrase in es")
    call("themes check high-contrast").shows("at least 7 (text 21.00, muted 13.61, accent 16.12,")
    least = call("themes check playful --json").json["contrasts"]
    assert least[0] == {"color": "text", "ground": "surface", "ratio": 12.34}


def test_phrases_that_fall_back_to_english_are_named(
    call: Call, evening: Path, change: Change
) -> None:
    printed = call("themes check", evening, "--json").json
    assert (printed["theme"], printed["passed"], printed["english"]) == ("evening", True, {})
    assert printed["languages"] == ["en", "de", "es"]
    assert {tuple(row) for row in printed["checks"]} == {("check", "ok", "problems", "found")}
    assert all(row["ok"] for row in printed["checks"])
    colors = {contrast["color"] for contrast in printed["contrasts"]}
    assert colors == {"text", "muted", "accent", "positive", "neutral", "negative"}
    folder = change("phrases.es.toml", "\nrest = [", "\nbreak = [")
    called = call("themes check", folder)
    called.shows("✓ has every phrase in en", "There is no wording for rest (es);", code=1)
    assert re.search(r"✗ has every phrase in es \(\d+ wordings\)", called.out)
    printed = call("themes check", folder, "--json").json
    assert (printed["passed"], printed["english"]) == (False, {"es": ["rest"]})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "old", "new", "says"),
    [
        ("theme.toml", 'title = "Evening"', "", "✗ has a title, a summary, and dark = true or false"),
        ("theme.toml", "#6b5138", "#d0c0a0", "    muted on surface has a contrast of 1.49, less than 4.5."),
        ("theme.toml", "[faces]\nneutral", "[faces]\nblank", "✗ has every expression, all of one size"),
        ("theme.toml", "shake = [", "shiver = [", "    There is no gesture shake."),
        ("theme.toml", 'gesture = "cheer"', 'gesture = "jump"', "✗ has a valid voice, manner and tones"),
        ("theme.toml", "[faces]\n", "[faces\n", "✗ can be read\n    theme.toml is not TOML: "),
        ("phrases.es.toml", "greeting = [", "greeting = ", "✗ can be read\n    phrases.es.toml is not TOML: "),
        ("phrases.es.toml", "greeting = [", "greeting = ", "✓ has every phrase in en"),
        ("phrases.es.toml", "¡Casi, casi!", "¡Casi once!", "holds a number: '¡Casi once! ¡Lo he visto!'."),
        ("phrases.en.toml", "goal = ", "gaol = ", "✗ has the vocabulary in en"),
        ("phrases.en.toml", "[units]", '[units]\n"" = "x"', "    A unit in units (en) has an empty name."),
        ("theme.toml", "minimum_contrast = 4.5", "minimum_contrast = 1", "    minimum_contrast is 1; it must be at"),
    ],
)  # fmt: skip
def test_each_breach_of_the_contract_is_named(
    call: Call, change: Change, file: str, old: str, new: str, says: str
) -> None:
    called = call("themes check", change(file, old, new))
    called.shows(says, code=1)
    assert "passes all checks" not in called.out


def test_screen_texts_of_a_theme_are_checked_in_every_language(call: Call, evening: Path) -> None:
    spanish = evening / "words.es.toml"
    spanish.write_text('"Press: {key}" = "¡Pulsa {key}!"\n"Help" = "¿Qué es esto?"\n', "utf-8")
    call("themes check", evening).shows("✓ has valid texts for the screens in es (2 texts)")
    spanish.write_text('"level {level}" = "{nivel}"\n"Halp" = "Ayuda"\n"Quit" = 3', "utf-8")
    (evening / "words.fr.toml").write_text('"Help = ', "utf-8")
    call("themes check", evening).shows(
        "✗ has valid texts for the screens in es (1 texts)",
        "    The wording of 'level {level}' in words.es.toml lacks {level}.",
        "    The wording of 'Quit' in words.es.toml is not a text.",
        "    No screen shows 'Halp', which words.es.toml translates.",
        "✗ has valid texts for the screens in fr\n    words.fr.toml is not TOML: ",
        code=1,
    )


@pytest.mark.usefixtures("own_themes")
def test_a_name_or_a_folder_may_be_checked(
    call: Call, evening: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(evening.parent)
    (evening.parent / "calm").mkdir()
    for name, named in (("calm", "calm"), ("evening", "evening"), (f"{evening}/", "evening")):
        call("themes check", name).shows(f"{named} passes all checks.")
    call("themes check", evening.parent / "calm").shows("There is no theme.toml.", code=1)
