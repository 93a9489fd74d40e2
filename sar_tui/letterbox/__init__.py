"""Sealed letters between a clinic and the homes where people train, in a folder that both reach."""

FILE = "letterbox.json"
"""File in the data folder that says who it is in a letterbox; without it, no module of this package
is loaded. Mode 0600.
"""
