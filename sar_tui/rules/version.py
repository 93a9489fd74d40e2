"""Version of the rules of the loop, by which a session is played."""

RULES = 1
"""Rises whenever the same inputs lead to other messages than before.

A recorded session is replayed and resumed only by the rules that it was recorded with.
"""
