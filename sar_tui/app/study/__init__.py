"""Parts of the screen of a study."""
