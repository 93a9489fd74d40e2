"""Closed-loop timing measurement over a pseudo-terminal."""
