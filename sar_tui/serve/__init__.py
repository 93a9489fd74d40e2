"""Web server for the operator's panel, an observer's view, or the agent alone, protected by a
token.
"""
