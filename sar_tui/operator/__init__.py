"""The operator's panel (Wizard of Oz): the participant's view, pending proposals, and all
commands.
"""
