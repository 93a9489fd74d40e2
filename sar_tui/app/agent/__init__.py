"""The agent on screen: drawn during a session, or alone in a window of its own."""
