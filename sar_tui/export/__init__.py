"""Data that leaves: sessions as files that other programs read."""
