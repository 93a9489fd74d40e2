"""Decisions as pure functions of (state, result), so that they can be read, tested and replayed."""
