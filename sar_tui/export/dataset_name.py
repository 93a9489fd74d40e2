"""The name of an exported data set, which tells simulated sessions from live ones."""

from collections.abc import Set


def dataset_name(modes: Set[str]) -> str:
    """Return a name for people.

    Args:
        modes: of the sessions.
    """
    if modes <= {"live"}:
        return "Sessions of motor tasks"
    return f"Sessions of motor tasks ({'some are' if 'live' in modes else 'all'} simulated)"
