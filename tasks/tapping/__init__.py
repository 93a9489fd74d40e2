"""The finger tapping test."""
