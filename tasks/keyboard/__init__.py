"""The keyboard reaction task (thesis 4.2.1)."""
