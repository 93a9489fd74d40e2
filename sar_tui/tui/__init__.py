"""The parts that all Textual apps of sar-tui share."""
