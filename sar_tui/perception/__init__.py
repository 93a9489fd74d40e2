"""Percepts from sensors that several tasks share."""
