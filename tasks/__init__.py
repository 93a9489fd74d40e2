"""The tasks that ship: one folder each, loaded by path like anyone's own."""
