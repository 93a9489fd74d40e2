"""The errors that code of a plug-in may raise without ending the program."""

PLUGIN_ERRORS = (Exception, SystemExit)
"""Errors of a task, a view or a device; `sys.exit` in a plug-in is an error, too."""


def describe(error: BaseException) -> str:
    """Return "ValueError: why"; the type alone if the error of a plug-in cannot say why."""
    try:
        return f"{type(error).__name__}: {error}"
    except PLUGIN_ERRORS:
        return type(error).__name__
