"""The n-back task."""
