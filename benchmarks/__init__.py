"""Timing, start-up and simulation, measured on the machine at hand: ``python -m benchmarks``."""
