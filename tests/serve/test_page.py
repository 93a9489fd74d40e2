"""All parts of the page come from this server."""

import re
from pathlib import Path

import textual_serve

from sar_tui.serve import server

PAGE = Path(server.__file__).parent / "page"
LIBRARY = Path(textual_serve.__file__).parent / "static"


def test_page_refers_only_to_existing_files() -> None:
    page = (PAGE / "index.html").read_text("utf-8")
    named = re.findall(r'(?:src|href)="([^"]*)"', page)
    named += re.findall(r'url\("?([^")]*)"?\)', (PAGE / "page.css").read_text("utf-8"))
    named.remove("data:,")
    folders = {"page": PAGE, "library": LIBRARY}
    files = [folders[name.split("/")[1]] / name.split("/", 2)[2] for name in named]
    assert len(files) == 8
    assert [file for file in files if not file.is_file()] == []


def test_scripts_and_styles_contain_no_other_hosts() -> None:
    served = [
        *PAGE.iterdir(),
        *(path for path in LIBRARY.rglob("*") if path.suffix in (".js", ".css")),
    ]
    for path in served:
        text = re.sub(r"/\*.*?\*/", "", path.read_text("utf-8"), flags=re.DOTALL)
        assert re.findall(r"(?:https?|wss?)://[\w.-]+", text) == [], path.name


def test_page_has_no_inline_script_or_handler() -> None:
    page = (PAGE / "index.html").read_text("utf-8")
    assert re.findall(r"<script(?![^>]*src=)", page) == []
    assert re.findall(r"\son\w+=", page) == []
    assert "script-src 'self';" in server._HEADERS["Content-Security-Policy"]
