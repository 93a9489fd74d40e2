"""Links of sessions whose settings let operators join, although they are begun or resumed in the
app.
"""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from sar_tui.rules.settings.operator import OperatorSettings
from sar_tui.runs.plan import Plan
from sar_tui.store import sessions

if TYPE_CHECKING:  # needs packages that are loaded only if operators can join
    from sar_tui.link.broker_process import BrokerProcess


@contextmanager
def link_of(
    what: Plan | str, database: sqlite3.Connection, folder: Path
) -> "Iterator[BrokerProcess | None]":
    """Open the link of a session for the duration of the block, if its settings let operators join;
    else give None.

    It listens on this machine only, as with ``sar-tui run --operator``.

    Args:
        what: the plan of a new session, which has an id; or the id of an interrupted one.
        database, folder: where that session is.

    Raises:
        StoreError: there is no such session.
        LinkError: the link cannot be opened.
    """
    if isinstance(what, Plan):
        session, task, can_join = what.id, what.task.name, what.parameters.operator_joins
        codes = what.participants
        lost_ms = what.parameters.operator_lost_ms
    else:
        row, default = sessions.find(database, folder, what), OperatorSettings()
        session, task, codes = row["id"], row["task"], sessions.codes(row)
        can_join = row["parameters"].get("operator_joins", default.operator_joins)
        lost_ms = row["parameters"].get("operator_lost_ms", default.operator_lost_ms)
    if not can_join:
        yield None
        return
    from sar_tui.link.listening import ListenOptions, open_link

    with open_link(
        folder, session, task, codes, ListenOptions(operator=True, end=None), lost_ms
    ) as link:
        yield link
