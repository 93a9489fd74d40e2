"""Long-term memory: SQLite, in which nothing acknowledged is ever lost."""
