"""Decisions as pure functions of state and result, so that they can be read, tested and replayed."""
