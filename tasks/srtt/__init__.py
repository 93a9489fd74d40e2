"""The serial reaction time task (Nissen & Bullemer 1987)."""
