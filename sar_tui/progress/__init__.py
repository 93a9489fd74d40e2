"""Estimates of a person's progress over sessions. Pure: from numbers to numbers."""
