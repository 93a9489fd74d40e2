"""Long-term memory in SQLite. An acknowledged trial is never lost."""
