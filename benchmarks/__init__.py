"""Timing, start-up and scale, measured on the machine at hand: ``python -m benchmarks``."""
