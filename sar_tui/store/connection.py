"""The connection from the terminal to this machine: SSH and multiplexers make timing less exact.

It is apart from `provenance`, because the empty first screen names it, and is shown before tasks and
the versions of packages are loaded.
"""

import os

_MULTIPLEXERS = {"tmux": "TMUX", "screen": "STY", "zellij": "ZELLIJ"}


def is_ssh() -> bool:
    """Return True if the terminal is connected through SSH."""
    return any(name in os.environ for name in ("SSH_CONNECTION", "SSH_TTY", "SSH_CLIENT"))


def multiplexer() -> str | None:
    """Return the name of the terminal multiplexer that the program runs in; None if there is
    none.
    """
    return next((name for name, sign in _MULTIPLEXERS.items() if sign in os.environ), None)


def timing_flags() -> list[str]:
    """Return the parts of the connection that are known to make timing less exact."""
    return [*(["ssh"] if is_ssh() else []), *filter(None, [multiplexer()])]
