"""Reads the JSON columns of the database."""

from typing import Any

import msgspec

from sar_tui.store.database import damaged


def read_json(text: str) -> Any:
    """Return the value of a JSON column. Raises StoreError if it is no JSON: a byte of the file has
    changed.
    """
    try:
        return msgspec.json.decode(text)
    except (msgspec.DecodeError, TypeError) as error:
        raise damaged() from error
