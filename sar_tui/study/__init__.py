"""Studies: what a plan (``study.toml``) says, and what follows from it."""
