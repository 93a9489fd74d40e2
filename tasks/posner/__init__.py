"""Posner's cueing task, with the agent's gaze as the cue."""
