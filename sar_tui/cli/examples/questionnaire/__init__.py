"""Questions between attempts."""
