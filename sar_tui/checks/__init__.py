"""Checks that a task or theme plug-in fulfils its contract."""
