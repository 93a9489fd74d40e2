"""What the agent speaks, sounds and moves with. The screen is the app itself: its output lives in ``app/``."""
