"""Sealed letters between a clinic and the homes where people train, in a folder that both reach."""
