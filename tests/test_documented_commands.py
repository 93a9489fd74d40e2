"""Commands on the pages: what they show, and that they name nobody."""

import re
import shlex
from pathlib import Path

import pytest

from sar_tui.loop.task import Task
from sar_tui.rules.parameters import build

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
GIVEN_NAMES = set(
    """
    alice ana andrea anna barbara bob carla carlos carmen charlie clara daniel david diego elena emma eva felix frank
    hans jane joe john jose josef juan julia karl klaus laura lena linda lisa lucia luisa marco maria mario
    marta martin mary michael miguel mike nina otto pablo paul paula pedro peter rosa sam sara sarah sofia susan thomas
    """.split()
)
"""Some that examples are often given; without those that are also words, such as ``max`` and
``jan``.
"""


def commands(page: Path) -> list[list[str]]:
    """Return the words of each command on a page, without its comment."""
    blocks = re.findall(
        r"^```sh\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    lines = "".join(blocks).replace("\\\n", " ").splitlines()
    return [shlex.split(line, comments=True) for line in lines if "sar-tui run" in line]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_an_operator_who_joins_a_documented_session_has_feedback_to_approve(
    page: Path, keyboard: type[Task]
) -> None:
    for words in commands(page):
        if "--operator" in words:
            pairs = [
                words[index + 1].split("=") for index, word in enumerate(words) if word == "--set"
            ]
            settings = build(keyboard.Parameters, dict(pairs))
            assert settings.operator_feedback == "approve", words  # type: ignore[attr-defined]


@pytest.mark.parametrize("folder", ["docs", "sar_tui", "tasks", "themes"])
def test_examples_and_help_name_nobody(folder: str) -> None:
    texts = [
        path
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".md", ".toml", ".svg")
    ]
    for path in (*texts, *ROOT.glob("*.md")):
        found = GIVEN_NAMES & set(
            re.findall(r"[^\W\d_]+", path.read_text(encoding="utf-8").lower())
        )
        assert not found, f"{path}: {found}"
