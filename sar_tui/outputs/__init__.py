"""Outputs: speech, tones, servos, robots. The output for the screen belongs to the app, in
``app/``.
"""
