"""Reports on a session, computed from its record. Nothing here prints or writes."""
