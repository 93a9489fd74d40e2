"""Finger tapping: as many responses as possible within a time."""
