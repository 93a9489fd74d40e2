"""The errors that code of a plug-in may raise without ending the program."""

PLUGIN_ERRORS = (Exception, SystemExit)
"""Errors of a task, a view or a device; `sys.exit` in a plug-in is an error, too."""
