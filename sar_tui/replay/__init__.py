"""Recorded sessions run again: their inputs go through the nodes, and what follows is compared with
the record.
"""
