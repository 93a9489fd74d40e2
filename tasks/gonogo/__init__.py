"""The Go/No-Go task."""
