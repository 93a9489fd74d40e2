"""BIDS, the Brain Imaging Data Structure: behaviour, events, and motion of each session, a file for
each idea.
"""
