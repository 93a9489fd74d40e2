"""Speech and tones: outputs use `mixer`; `voice_main` is the child process that speaks and
plays.
"""
