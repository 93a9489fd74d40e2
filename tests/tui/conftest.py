"""Set-up that the tests of the app have, too."""

from tests.app.conftest import (
    a_plain_terminal,
    driver,
    no_collection,
    no_session_to_join,
    open_session,
    opened,
)  # fmt: skip

__all__ = [
    "a_plain_terminal", "driver", "no_collection", "no_session_to_join", "open_session", "opened",
]  # fmt: skip
