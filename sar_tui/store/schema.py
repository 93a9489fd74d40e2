"""Tables and views of a new database, and the upgrade of one that an earlier release wrote.

Both are made from `store.tables` and `store.views`. The columns are a contract: see
docs/data-dictionary.md.
"""

import sqlite3

import sqlite_utils

from sar_tui.store import tables, views


def create(database: sqlite3.Connection) -> None:
    """Give an empty database all tables and views."""
    db = sqlite_utils.Database(database)
    with db.atomic():
        for table in tables.TABLES.values():
            _create(database, table)
        database.execute(_TOPIC_OF_PRESENCE)
        _create_views(db)
        database.execute(f"PRAGMA user_version={tables.VERSION}")


def upgrade(database: sqlite3.Connection, version: int) -> None:
    """Add what later versions of the data declare to a database of an earlier one."""
    db = sqlite_utils.Database(database)
    with db.atomic():
        for table in tables.TABLES.values():
            if table.since > version:
                _create(database, table)
                continue
            for column in table.columns:
                if column.since > version:
                    database.execute(f"ALTER TABLE {table.name} ADD COLUMN {column.definition}")
        _create_views(db)
        database.execute(f"PRAGMA user_version={tables.VERSION}")


def _create(database: sqlite3.Connection, table: tables.Table) -> None:
    for statement in (table.create, *table.indexes):
        database.execute(statement)


def _create_views(db: sqlite_utils.Database) -> None:
    for name, query in views.VIEWS.items():
        db.create_view(name, query, replace=True)


_TOPIC_OF_PRESENCE = "INSERT INTO topics (id, name, fields) VALUES (1, 'operator/presence', '')"
"""Its number is a literal in an index."""
