"""The nodes of the loop, one a file, in the order a key press meets them."""

VITAL = ("perception", "event_handler", "memory")
"""The nodes without which a session cannot go on."""
