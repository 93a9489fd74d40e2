"""The page of all texts that a theme can set is up to date; and a theme is told which of them it
lacks.
"""

import json
import os
from pathlib import Path

import sar_tui
from sar_tui.checks.task_translations import all_texts, declared, texts_in, translated
from sar_tui.checks.theme import missing
from sar_tui.model.language import read_words
from sar_tui.plugins import Catalogue, task_folder
from tests.program import Call

PAGE = Path(__file__).parents[2] / "docs" / "screen-texts.md"
_PACKAGE = Path(sar_tui.__file__).parent
_HEAD = """# All texts of the screens

These are the texts on the screens of participants and therapists that a theme can set, and that a new language
translates, in `words.<language>.toml` ([themes and words](themes-and-words.md)). The English text is the key; slots
such as `{count}` stay. What the agent says is in `phrases.<language>.toml`. This page is made from the program's lists;
`sar-tui themes check` prints what a theme lacks as lines to copy.
"""


def section(title: str, texts: set[str]) -> str:
    """A list of texts, each in quotation marks as it is the key in a file of words."""
    lines = "\n".join(json.dumps(text, ensure_ascii=False) for text in sorted(texts))
    return f"\n## {title}\n\n```text\n{lines}\n```\n"


def page(catalogue: Catalogue) -> str:
    """The page as it has to be."""
    shown, session = (
        set(read_words(_PACKAGE / name / "words.es.toml")) for name in ("app", "loop")
    )
    messages = "Instructions, goals and messages of a session"
    made = [_HEAD, section("Screens", shown), section(messages, session - shown)]
    for name in catalogue.task_names():
        kind = catalogue.task(name)
        code = (path.read_text("utf-8") for path in task_folder(kind).glob("*.py"))
        own = declared(kind).union(*map(texts_in, code))
        made.append(section(f"The task {name}", own - shown - session))
    return "".join(made)


def test_the_page_lists_all_texts(catalogue: Catalogue) -> None:
    made = page(catalogue)
    assert all(json.dumps(text, ensure_ascii=False) in made for text in all_texts(catalogue))
    if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
        PAGE.write_text(made, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == made, "write it anew with SAR_TUI_UPDATE_SNAPSHOTS=1"


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
