"""Gestures by servo motors on a Phidget controller: `servo` is the output, the other modules serve
it.
"""
