"""Checks that a task or theme plug-in keeps its contract."""
