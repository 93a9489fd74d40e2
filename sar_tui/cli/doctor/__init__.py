"""``sar-tui doctor``: a file for each group of checks."""
