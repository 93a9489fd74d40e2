"""Links between the pages lead to a file that exists, and to a heading in it; their pictures can be
drawn from the app.
"""

import re
from pathlib import Path

import pytest

from docs import pictures

ROOT = Path(__file__).parents[1]
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted(ROOT.glob("docs/*.md")),
    *sorted(ROOT.glob("tasks/*/*.md")),
]
_CODE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    text = _CODE.sub("", page.read_text(encoding="utf-8"))
    headings = [
        re.sub(r"\[(.*?)\]\(.*?\)", r"\1", line)
        for line in re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    ]
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    text = _CODE.sub("", page.read_text(encoding="utf-8"))
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        target, _, anchor = link.partition("#")
        file = page.parent / target if target else page
        if not link.startswith(("http://", "https://", "mailto:")) and not (
            file.exists() and (not anchor or anchor in anchors(file))
        ):
            broken.append(link)
    assert broken == []


@pytest.mark.slow
async def test_each_picture_is_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    present = sorted(path.name for path in pictures.IMAGES.glob("*.svg"))
    monkeypatch.setattr(pictures, "IMAGES", tmp_path)
    await pictures._draw()
    assert sorted(path.name for path in tmp_path.iterdir()) == present
