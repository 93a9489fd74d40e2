"""A choice reaction: one prompt, one key."""
