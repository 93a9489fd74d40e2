"""What every Textual app of ours shares."""
