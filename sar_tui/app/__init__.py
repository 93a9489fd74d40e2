"""The app: screens for participants and therapists. Its screen is also the session's first
output.
"""
