"""Exit codes of the program. They follow the shell: 128 plus the number of the signal that ended
it.
"""

FAILED = 1
BAD_INPUT = 2
"""Wrong usage, or input that cannot be used."""
INTERRUPTED = 130
"""Ctrl-C."""


def after_signal(number: int) -> int:
    """Return the exit code of a program that a signal ended."""
    return 128 + number
