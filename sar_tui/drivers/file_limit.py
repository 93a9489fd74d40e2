"""The largest file that this login may write (``ulimit -f``). Loads nothing else: every command
imports it first.
"""

try:
    import resource
except ImportError:  # Windows has no such limit
    resource = None  # type: ignore[assignment]


def largest_file() -> int | None:
    """Return the limit in bytes; None if there is none."""
    if resource is None:
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    return None if limit == resource.RLIM_INFINITY else limit
