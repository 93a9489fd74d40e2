"""Set-up that the tests of the app have, too."""

from tests.app.conftest import a_plain_terminal, no_collection, no_session_to_join

__all__ = ["a_plain_terminal", "no_collection", "no_session_to_join"]
