"""Nodes of the loop."""

VITAL = ("perception", "event_handler", "memory")
"""The nodes without which a session cannot continue."""
