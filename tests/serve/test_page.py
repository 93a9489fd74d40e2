"""Given the page that is served, when its parts are read, then each of them is of this server."""

import re
from pathlib import Path

import textual_serve

from sar_tui.serve import server

PAGE = Path(server.__file__).parent / "page"
LIBRARY = Path(textual_serve.__file__).parent / "static"


def test_the_page_refers_to_nothing_but_files_that_are_there() -> None:
    page = (PAGE / "index.html").read_text("utf-8")
    named = re.findall(r'(?:src|href)="([^"]*)"', page)
    named += re.findall(r'url\("?([^")]*)"?\)', (PAGE / "page.css").read_text("utf-8"))
    named.remove("data:,")
    folders = {"page": PAGE, "library": LIBRARY}
    files = [folders[name.split("/")[1]] / name.split("/", 2)[2] for name in named]
    assert len(files) == 7
    assert [file for file in files if not file.is_file()] == []


def test_no_script_or_style_knows_another_place() -> None:
    served = [*PAGE.iterdir(), *(path for path in LIBRARY.rglob("*") if path.suffix in (".js", ".css"))]
    for path in served:
        text = re.sub(r"/\*.*?\*/", "", path.read_text("utf-8"), flags=re.DOTALL)
        assert re.findall(r"(?:https?|wss?)://[\w.-]+", text) == [], path.name


def test_no_script_or_handler_stands_in_the_page_itself() -> None:
    page = (PAGE / "index.html").read_text("utf-8")
    assert re.findall(r"<script(?![^>]*src=)", page) == []
    assert re.findall(r"\son\w+=", page) == []
    assert "script-src 'self';" in server._HEADERS["Content-Security-Policy"]
