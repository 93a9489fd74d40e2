"""Textual widgets that screens, and the views of tasks, may use."""
