"""The tables that leave, a file each."""
