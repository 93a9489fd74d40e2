"""The pairs task: two people at one keyboard, in turn, against each other, or together."""
