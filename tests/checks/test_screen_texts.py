"""A theme is told which texts of the screens it lacks in a language."""

from pathlib import Path

from sar_tui.checks.task_translations import all_texts, translated
from sar_tui.checks.theme import missing
from sar_tui.plugins import Catalogue
from tests.program import Call


def test_no_text_is_missing_in_a_language_of_a_bundled_theme(catalogue: Catalogue) -> None:
    texts = all_texts(catalogue)
    for name in catalogue.theme_names():
        folder = catalogue.theme_folder(name)
        assert missing(folder, texts, lambda code: translated(catalogue, code)) == {}


def test_a_new_language_of_a_theme_is_told_what_it_lacks(call: Call, tmp_path: Path) -> None:
    assert call("themes new soir --to", tmp_path).out.count("!") == 0
    folder = tmp_path / "soir"
    (folder / "phrases.fr.toml").write_text((folder / "phrases.en.toml").read_text())
    words = '"Press {key} to start." = "Appuyez sur {key}."\n'
    (folder / "words.fr.toml").write_text(words, encoding="utf-8")
    found = call("themes check", folder, "--json").json["missing"]
    assert list(found) == ["fr"]
    called = call("themes check", folder)
    called.shows('    "1 minute" = ""\n', f"These {len(found['fr'])} are shown")
    called.shows("shown in English, unless words.fr.toml translates them")
    assert '"Press {key} to start." = ""' not in called.out
    assert "shown in English" not in call("themes new tard --to", tmp_path).out
