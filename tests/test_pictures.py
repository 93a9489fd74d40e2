"""The pictures of the documentation draw themselves: they fetch nothing, and one moves."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from docs.cast import Cast

IMAGES = sorted((Path(__file__).parents[1] / "docs" / "images").rglob("*.svg"))
SESSION = next(path for path in IMAGES if path.name == "session.svg")
FRAME = """<svg viewBox="0 0 100 90"><style>.terminal-7-r1 {{ fill: #fff }}</style>
<rect fill="#292929" stroke="x" width="98"/><rect fill="#000" x="0" y="1.5" width="9" height="24.65"/>
<text class="terminal-7-r1" x="0" y="20" textLength="61">Above</text>
<text class="terminal-7-r1" x="0" y="44.4" textLength="61">{0}</text></svg>"""


def cast_of(*words: str) -> Cast:
    cast = Cast()
    for word in words:
        frame = FRAME.format(word)
        app: Any = SimpleNamespace(export_screenshot=lambda title, frame=frame: frame)
        cast.show(app, 0.5)
    return cast


@pytest.mark.parametrize("path", IMAGES, ids=lambda path: path.stem)
def test_a_picture_fetches_nothing(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    ET.fromstring(text)
    assert re.findall(r"url\((?!#)|@import|<script|<image|href=\"(?!#)", text) == []


def test_the_moving_picture_is_short_and_small_and_stands_still_where_no_motion_is_wanted() -> None:
    text = SESSION.read_text(encoding="utf-8")
    (seconds,) = re.findall(r"animation-duration: ([\d.]+)s", text)
    assert 15 <= float(seconds) <= 25
    assert len(text) < 300_000
    assert "prefers-reduced-motion" in text
    assert "Demonstration: invented people." in text


def test_frames_share_rows_and_one_that_does_not_change_is_shown_longer() -> None:
    cast = cast_of("one", "one", "two")
    assert cast.seconds == 1.5
    text = cast.svg()
    assert text.count(">Above<") == text.count(">one<") == text.count(">two<") == 1
    assert text.count('<use href="#l0"') == 2
    assert "@keyframes k1 { 0% { visibility: hidden } 66.667% { visibility: visible }" in text
    assert ".f1 { visibility: visible }" in text.split("prefers-reduced-motion")[1]
