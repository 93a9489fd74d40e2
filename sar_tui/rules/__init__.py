"""Settings, and the decisions made by them: pure functions on immutable state."""
