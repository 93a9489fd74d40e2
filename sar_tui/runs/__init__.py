"""Runs sessions, live and simulated: plan, sensors, start and resume."""
