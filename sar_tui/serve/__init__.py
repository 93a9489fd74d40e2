"""A session in a browser: the operator's panel, an observer's view, or the agent alone; behind a token, on loopback."""
