"""Checks of the thesis' claims and our own by simulation: one experiment per file, listed in ``registry``."""
