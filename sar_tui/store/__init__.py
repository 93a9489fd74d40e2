"""Storage in SQLite. An acknowledged trial is never lost."""
