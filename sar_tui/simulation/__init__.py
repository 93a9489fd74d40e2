"""Simulated participants and operators."""
