"""What a paper has to report about a session, computed from its record. Nothing here prints, or writes."""
