"""The reaching task (thesis 4.2.2)."""
