"""The flanker task (Eriksen & Eriksen 1974)."""
