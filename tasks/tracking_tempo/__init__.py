"""Moving the hand to and fro in time with a metronome."""
