"""Checks claims of the thesis and of this project by simulation: one experiment per file, listed in
``registry``.
"""
