"""Reads what the first screen shows of studies."""

import sqlite3
from collections.abc import Sequence
from contextlib import suppress
from datetime import date, datetime

from sar_tui.app.study.words import card_words
from sar_tui.model.language import Language
from sar_tui.store.database import StoreError
from sar_tui.study import ledger
from sar_tui.study.plan import PlanError
from sar_tui.study.secret import key_file
from sar_tui.study.status import grid


def read_due(
    database: sqlite3.Connection, names: Sequence[str], who: str, today: date, tr: Language
) -> str:
    """Return what is due for a participant, of the newest of these studies in which something is;
    empty if nothing is.
    """
    now = datetime.combine(today, datetime.now().time()).astimezone()
    for name in reversed(names):
        with suppress(StoreError, PlanError):  # the screen of the study tells it
            frozen = ledger.find(database, name)
            people = ledger.people(database, frozen, who)
            for row in grid(frozen, people, key_file(name), now):
                if words := card_words(frozen.plan, row, today, tr):
                    return words
    return ""
