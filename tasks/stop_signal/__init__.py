"""The stop-signal task: a cross that comes too late to stop half of the responses."""
