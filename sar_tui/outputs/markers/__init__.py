"""Markers: the events of a session for recorders of EEG, motion and video, over LSL, UDP or a
serial line.
"""
