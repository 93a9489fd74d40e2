"""The name of the user who runs the program."""

import getpass
import re

_LONGEST = 32


def login_name() -> str:
    """Return the login name, reduced to letters, digits, - and _; empty if it is not known."""
    try:
        name = getpass.getuser()
    except (KeyError, OSError):  # no entry for the user, as in some containers
        name = ""
    return re.sub(r"[^A-Za-z0-9_-]", "", name).lstrip("_-")[:_LONGEST]
