"""A movement of the hand, measured by a motion sensor."""
