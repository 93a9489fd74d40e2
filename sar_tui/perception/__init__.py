"""Perception nodes that several tasks share: percepts from sensors."""
