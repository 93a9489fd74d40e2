"""Parts of the settings: the rules of difficulty, the preview, the versions."""
