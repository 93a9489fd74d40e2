"""The site of a database, such as a clinic, and those of rows that came from other databases."""

import re
import sqlite3

from sar_tui.store.database import StoreError, transaction
from sar_tui.store.schema import SITE
from sar_tui.store.tables import with_column

_CODE = re.compile(r"[A-Za-z0-9][A-Za-z0-9-]{0,15}")
OF_SITES = with_column("site")
"""Tables with a column ``site``: empty in the rows of the database's own site."""


def check_site(code: str) -> str:
    """Return a site's code as it is stored, in capital letters. Raise StoreError if it is not
    valid.
    """
    code = code.strip()
    # before the capitals: those of ß and ı are letters of other codes
    if not _CODE.fullmatch(code):
        raise StoreError(
            "A site's code has 1 to 16 letters, digits or -, and begins with a letter or digit, "
            "such as BERN.",
            bad_input=True,
        )
    return code.upper()


def resolved(column: str) -> str:
    """Return the SQL of a site's code from a column ``site``; it is empty only if this database has
    no code yet.
    """
    return SITE.format(column=column)


def own(db: sqlite3.Connection) -> str:
    """Return the code of the database's own site; empty if it has none."""
    row = db.execute("SELECT code FROM site").fetchone()
    return row[0] if row else ""


def of_session(db: sqlite3.Connection, session: str) -> str:
    """Return the code of the site at which a session was recorded; empty if the database has no
    code yet.
    """
    row = db.execute(
        f"SELECT {resolved('sessions.site')} FROM sessions WHERE id=?", (session,)
    ).fetchone()
    return row[0] if row else ""


def set_own(db: sqlite3.Connection, code: str) -> str:
    """Give the database's own site a code, and return it as it is stored.

    Raises:
        StoreError: the code is not valid, or another one is known outside of this database already.
    """
    code = check_site(code)
    with transaction(db) as connection:
        before = own(connection)
        if before and before != code and (reason := _known_outside(connection)):
            raise StoreError(
                f"This database is {before}, and stays so: {reason}. Its sessions would be those "
                "of two sites.",
                bad_input=True,
            )
        connection.execute("INSERT OR REPLACE INTO site (number, code) VALUES (1, ?)", (code,))
    return code


def _known_outside(db: sqlite3.Connection) -> str:
    """Return the reason why the code must not change, in words; empty if there is none."""
    if any(
        db.execute(f"SELECT 1 FROM {table} WHERE site<>'' LIMIT 1").fetchone() for table in OF_SITES
    ):
        return "data of other sites was merged into it"
    if db.execute("SELECT 1 FROM exports WHERE site='' AND format='parquet' LIMIT 1").fetchone():
        return "data was exported under this code"
    if db.execute("SELECT 1 FROM correspondents LIMIT 1").fetchone():
        return "people who train at home know the clinic by it"
    return ""
