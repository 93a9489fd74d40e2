"""Typed texts pass one rule wherever they are stored: of a bounded length, and nothing that a
terminal obeys.
"""

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.store import participants, programmes
from sar_tui.store.database import StoreError, connect
from sar_tui.store.programmes import Programme
from sar_tui.store.texts import check_text
from tests.recorded import event, score


@pytest.fixture
def database(data: Path) -> Iterator[Connection]:
    with closing(connect(data)) as opened:
        participants.add(opened, "P01")
        yield opened


def told(database: Connection, text: str) -> object:
    return event(database, "P01", "2026-01-01", what=text, severity="mild")


def noted(database: Connection, text: str) -> object:
    return score(database, "P01", "ARAT", "2026-01-02", 5, text)


def reasoned(database: Connection, text: str) -> object:
    return programmes.save(database, "P01", "keyboard", Programme(), after=0, reason=text)


@pytest.mark.parametrize("store", [told, noted, reasoned])
@pytest.mark.parametrize("text", ["a\x1b[2J", "a\u202eb", "a\x00b", "a\x9bb", "a\udc80b"])
def test_what_a_terminal_would_obey_is_refused_where_it_is_typed(
    database: Connection, store: Callable[[Connection, str], object], text: str
) -> None:
    with pytest.raises(
        StoreError, match=r"has control characters|bytes that are not UTF-8"
    ) as refused:
        store(database, text)
    assert refused.value.bad_input


@pytest.mark.parametrize("text", ["Le duele.\r\n\tNo más.", "=2+2", "👩🏽‍⚕️ ñ", "x" * 50])
def test_other_texts_are_kept(text: str) -> None:
    assert check_text("The text", f" {text}\n", 50) == text


def test_a_text_that_is_too_long_is_refused() -> None:
    with pytest.raises(StoreError, match="The note is too long: at most 50 characters"):
        check_text("The note", "x" * 51, 50)
