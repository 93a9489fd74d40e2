"""Simulated participants: who they are (person) and how they sit at the keyboard (participant)."""
